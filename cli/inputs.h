// What several commands read the same way: configs with their built-in names, champions, lists of objects.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "assets/assets.h"
#include "common/config.h"
#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp::cli {

// Built-in objects and hands, as load_config wants them.
KnownNames known_names();

// A champion file (*.pb), or a run folder that holds champion.pb. Size, shape, network and genome are
// checked.
Result<proto::Champion> read_champion(const std::filesystem::path& path);

// A hand that a flag names: built-in, or a file. Warnings are told.
Result<proto::HandBundle> load_hand(const std::string& name_or_path);

// Writes by way of a temporary file beside it: a reader sees the old file or the new one, whole.
Status write_file(const std::filesystem::path& path, std::string_view data);

// Mesh files (OBJ, STL, PLY, DAE, glTF) and object files in a folder, sorted by name.
Result<std::vector<std::string>> objects_in(const std::filesystem::path& folder);
bool is_mesh_file(const std::filesystem::path& path);

}  // namespace evograsp::cli

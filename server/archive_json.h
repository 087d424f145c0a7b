// The map of grasps in run.db, as a document of the HTTP API and as champions of its cells.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "common/result.h"
#include "server/store_reader.h"

namespace evograsp::server {

// kNotFound for a run without neat.archive.
Result<nlohmann::json> archive_json(StoreReader& reader);
// Serialised proto::Champion of the elite in a cell: generation and fitness are the elite's. kNotFound for an
// empty cell, or none.
Result<std::string> elite_of(StoreReader& reader, std::uint32_t x, std::uint32_t y);

}  // namespace evograsp::server

// What objects and hands share: names, files and content addresses.
#pragma once

#include <google/protobuf/message_lite.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace evograsp::assets {

// Lower-case hex SHA-256 of the deterministic serialisation.
std::string bundle_id(const google::protobuf::MessageLite& bundle);
// What can be handed to a worker: at most kMaxBundle.
inline constexpr std::size_t kMaxBundle = std::size_t{16} << 20;  // bytes, unpacked
Status check_size(const google::protobuf::MessageLite& bundle);
// A file that every binary carries, by its path below configs/ ("objects/mug.txtpb").
std::optional<std::string_view> embedded_file(std::string_view path);
// Names of the embedded *.txtpb files in a folder ("objects/").
std::vector<std::string> builtin_names(std::string_view folder);
// The file a name means: below base if there, else as given; empty when neither exists.
std::filesystem::path find_file(const std::string& name, const std::filesystem::path& base);
// "NAME: no such object or file; built in are a, b, c" with a near miss named.
std::string unknown_name(std::string_view kind, const std::string& name,
                         const std::vector<std::string>& builtin);

}  // namespace evograsp::assets

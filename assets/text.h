// Files people write, read within bounds.
#pragma once

#include <google/protobuf/message.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace evograsp::assets {

// The whole file, or an error that names it: not there, not a plain file, empty, larger than max_bytes,
// unreadable.
Result<std::string> read_file(const std::filesystem::path& path, std::size_t max_bytes);

// Protobuf text into a message, all annotations checked. The error holds every complaint as
// `file:line:column: message`, one a line.
Status parse_message(std::string_view text, const std::string& file_name, google::protobuf::Message& message);

}  // namespace evograsp::assets

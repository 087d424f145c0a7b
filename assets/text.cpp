#include "assets/text.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "common/config.h"

namespace evograsp::assets {

Result<std::string> read_file(const std::filesystem::path& path, std::size_t max_bytes) {
  const std::string name = path.string();
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return fail(ErrorCode::kNotFound, name + ": no such file");
  if (!std::filesystem::is_regular_file(status))
    return fail(ErrorCode::kInvalid, name + ": not a plain file");
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(ErrorCode::kIo, name + ": cannot be read: " + std::strerror(errno));
  std::string bytes;
  char block[1 << 16];
  while (in.read(block, sizeof block), in.gcount() > 0) {
    bytes.append(block, static_cast<std::size_t>(in.gcount()));
    if (bytes.size() > max_bytes) {
      return fail(ErrorCode::kInvalid,
                  name + ": larger than the " + std::to_string(max_bytes) + " bytes allowed");
    }
  }
  if (in.bad()) return fail(ErrorCode::kIo, name + ": reading failed");
  if (bytes.empty()) return fail(ErrorCode::kInvalid, name + ": the file is empty");
  return bytes;
}

Status parse_message(std::string_view text, const std::string& file_name,
                     google::protobuf::Message& message) {
  std::string complaints;
  for (const Diagnostic& diagnostic : parse_text(text, file_name, message)) {
    complaints += (complaints.empty() ? "" : "\n") + diagnostic.text();
  }
  if (!complaints.empty()) return fail(ErrorCode::kInvalid, complaints);
  return {};
}

}  // namespace evograsp::assets

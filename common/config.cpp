#include "common/config.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <fstream>

#include "common/near_miss.h"
#include "common/text_reader.h"
#include "common/utf8.h"
#include "embedded/configs.h"

namespace evograsp {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargestText = 1 << 20;
constexpr std::string_view kExtension = ".txtpb";

std::vector<std::string> names_beside(const fs::path& path) {
  std::vector<std::string> names;
  std::error_code error;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (fs::directory_iterator it(folder, error), end; !error && it != end && names.size() < 1000;
       it.increment(error)) {
    names.push_back(it->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::string Diagnostic::text() const {
  if (line <= 0) return file + ": " + message;
  return file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": " + message;
}

std::string text(const std::vector<Diagnostic>& diagnostics) {
  std::string out;
  for (const Diagnostic& d : diagnostics) out += (out.empty() ? "" : "\n") + d.text();
  return out;
}

const char* origin_name(Origin origin) {
  switch (origin) {
    case Origin::kFlag:
      return "flag";
    case Origin::kEnvironment:
      return "environment";
    case Origin::kFile:
      return "file";
    case Origin::kDefault:
      break;
  }
  return "default";
}

std::vector<Diagnostic> parse_text(std::string_view text, const std::string& file_name,
                                   google::protobuf::Message& message, Positions* positions) {
  message.Clear();
  if (text.size() > kLargestText) {
    return {{file_name, 0, 0, "larger than 1 MiB: not a file that a person wrote"}};
  }
  if (const auto stranger = first_non_text(text)) {
    return {{file_name, 0, 0, "not a text file: byte " + std::to_string(*stranger) + " is no UTF-8 text"}};
  }
  TextReader reader(text, file_name);
  auto diagnostics = reader.read(message);
  if (positions != nullptr) *positions = reader.positions();
  return diagnostics;
}

Result<std::string> read_file(const fs::path& path, std::size_t limit) {
  const std::string name = path.string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    const std::string advice = did_you_mean(path.filename().string(), names_beside(path));
    return fail(ErrorCode::kNotFound, name + ": no such file" + advice);
  }
  if (fs::is_directory(status)) return fail(ErrorCode::kInvalid, name + ": is a folder, not a file");
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(ErrorCode::kIo, name + ": cannot be opened for reading");
  std::string data;
  char buffer[1 << 16];
  while (in.read(buffer, sizeof buffer) || in.gcount() > 0) {
    data.append(buffer, static_cast<std::size_t>(in.gcount()));
    if (data.size() > limit) {
      return fail(ErrorCode::kInvalid,
                  name + ": larger than " + std::to_string(limit) + " bytes, the most that is read");
    }
  }
  if (in.bad()) return fail(ErrorCode::kIo, name + ": reading failed");
  return data;
}

std::vector<std::string> builtin_configs() {
  std::vector<std::string> names;
  for (const embedded::File& file : embedded::configs()) {
    names.emplace_back(file.name.substr(0, file.name.size() - kExtension.size()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<std::string_view> builtin_config(std::string_view name) {
  for (const embedded::File& file : embedded::configs()) {
    if (file.name.substr(0, file.name.size() - kExtension.size()) == name) return file.data;
  }
  return std::nullopt;
}

}  // namespace evograsp

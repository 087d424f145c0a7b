#include "cli/wrench_file.h"

#include <unistd.h>
#include <zlib.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>

namespace evograsp::cli {
namespace {

constexpr int kMaxLine = 1024;
// Little of a file may be a day's reading once it is unpacked. Sets of numbers pack about 3 to 1.
constexpr z_off_t kMuch = 16 << 20;  // bytes; less is never refused
constexpr z_off_t kMostPacked = 100;

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

// The whole word, or nothing; independent of the locale.
template <class Number>
std::optional<Number> number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

struct WrenchReader::File {
  std::string name;
  gzFile file = nullptr;
  int line = 0;
  z_off_t unpacked = 0;  // bytes so far

  ~File() {
    if (file != nullptr) gzclose(file);
  }

  tl::unexpected<Error> wrong(const std::string& what, int at) const {
    return fail(ErrorCode::kInvalid, name + ":" + std::to_string(at) + ": " + what);
  }

  // The next line that says something; nothing at the end.
  Result<std::optional<std::string>> read_line() {
    char text[kMaxLine + 2];
    while (gzgets(file, text, sizeof text) != nullptr) {
      ++line;
      const std::size_t length = std::strlen(text);
      unpacked += static_cast<z_off_t>(length);
      if (unpacked > kMuch && unpacked / kMostPacked > gzoffset(file))
        return wrong("packed more than " + std::to_string(kMostPacked) + " to 1: no file of wrenches is",
                     line);
      if (length > kMaxLine) return wrong("a line of more than " + std::to_string(kMaxLine) + " bytes", line);
      std::string_view all(text, length);
      if (all.ends_with('\n')) all.remove_suffix(1);
      const std::size_t begin = all.find_first_not_of(" \t\r");
      if (begin == std::string_view::npos || all[begin] == '#') continue;
      return std::optional<std::string>(all);
    }
    int code = Z_OK;
    const char* why = gzerror(file, &code);
    if (code != Z_OK && code != Z_STREAM_END) {
      return fail(ErrorCode::kIo, name + ": " + (code == Z_ERRNO ? std::strerror(errno) : why));
    }
    return std::optional<std::string>();
  }

  Result<int> read_header(std::string_view text, WrenchSet& set) const;
  Result<sim::Wrench> read_wrench(std::string_view text) const;
};

// Gives the number of wrenches that follow.
Result<int> WrenchReader::File::read_header(std::string_view text, WrenchSet& set) const {
  const auto words = words_of(text);
  if (words[0] != "set") {
    return wrong("'set OBJECT ID wrenches N' expected, found '" + std::string(words[0].substr(0, 40)) + "'",
                 line);
  }
  if (words.size() < 5 || words.size() % 2 == 0) {
    return wrong("a set's header is 'set OBJECT ID' and pairs of a key and a value, 'wrenches N' among them",
                 line);
  }
  set.object = words[1];
  set.id = words[2];
  set.line = line;
  std::optional<int> count;
  for (std::size_t i = 3; i + 1 < words.size(); i += 2) {
    if (words[i] == "wrenches") count = number<int>(words[i + 1]).value_or(-1);
    if (words[i] == "contacts") set.contacts = number<int>(words[i + 1]).value_or(0);
    if (words[i] == "epsilon") set.epsilon = number<double>(words[i + 1]);
  }
  if (!count) return wrong("the header does not say how many wrenches follow ('wrenches N')", line);
  if (*count < 0 || *count > kMaxWrenches) {
    return wrong("'wrenches' must be a whole number from 0 to " + std::to_string(kMaxWrenches), line);
  }
  return *count;
}

Result<sim::Wrench> WrenchReader::File::read_wrench(std::string_view text) const {
  const auto words = words_of(text);
  if (words.size() != 6) {
    return wrong("a wrench is six numbers (fx fy fz tx ty tz), found " + std::to_string(words.size()) +
                     (words.size() == 1 ? " word" : " words"),
                 line);
  }
  sim::Wrench wrench;
  for (int x = 0; x < 6; ++x) {
    const auto value = number<double>(words[x]);
    if (!value || !std::isfinite(*value)) {
      return wrong("'" + std::string(words[x].substr(0, 40)) + "' is not a finite number", line);
    }
    wrench[x] = *value;
  }
  return wrench;
}

WrenchReader::WrenchReader(std::unique_ptr<File> file) : file_(std::move(file)) {}
WrenchReader::~WrenchReader() = default;
WrenchReader::WrenchReader(WrenchReader&&) noexcept = default;

Result<WrenchReader> WrenchReader::open(const std::string& path) {
  auto file = std::make_unique<File>();
  file->name = path == "-" ? "standard input" : path;
  std::error_code error;
  if (path == "-") {
    file->file = gzdopen(dup(STDIN_FILENO), "rb");
  } else if (!std::filesystem::exists(path, error)) {
    return fail(ErrorCode::kNotFound, path + ": no such file");
  } else if (std::filesystem::is_directory(path, error)) {
    return fail(ErrorCode::kInvalid, path + ": a folder, not a file of wrench sets");
  } else {
    file->file = gzopen(path.c_str(), "rb");
  }
  if (file->file == nullptr)
    return fail(ErrorCode::kIo, file->name + ": cannot be read: " + std::strerror(errno));
  return WrenchReader(std::move(file));
}

Result<std::optional<WrenchSet>> WrenchReader::next() {
  auto header = file_->read_line();
  if (!header) return tl::unexpected(header.error());
  if (!*header) return std::optional<WrenchSet>();
  WrenchSet set;
  const auto count = file_->read_header(**header, set);
  if (!count) return tl::unexpected(count.error());
  for (int i = 0; i < *count; ++i) {
    auto text = file_->read_line();
    if (!text) return tl::unexpected(text.error());
    if (!*text) {
      return file_->wrong(
          "the file ends after " + std::to_string(i) + " of " + std::to_string(*count) + " wrenches",
          file_->line);
    }
    const auto wrench = file_->read_wrench(**text);
    if (!wrench) return tl::unexpected(wrench.error());
    set.wrenches.push_back(*wrench);
  }
  return std::optional<WrenchSet>(std::move(set));
}

}  // namespace evograsp::cli

#include "cli/report.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

#include "cli/table.h"

namespace evograsp::cli {

namespace {

// Errors quote strangers: their lines stay, what would steer a terminal does not.
std::string clean(const std::string& text) {
  std::string out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    out += (begin == 0 ? "" : "\n") + printable(std::string_view(text).substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

}  // namespace

int report(const Error& error) {
  std::fprintf(stderr, "evograsp: %s\n", clean(error.message).c_str());
  return static_cast<int>(error.code);
}

int report(const std::vector<Diagnostic>& diagnostics) {
  std::fprintf(stderr, "%s\n", clean(text(diagnostics)).c_str());
  return static_cast<int>(ErrorCode::kInvalid);
}

void warn(const std::string& message) {
  std::fprintf(stderr, "evograsp: warning: %s\n", clean(message).c_str());
}

}  // namespace evograsp::cli

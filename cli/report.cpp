#include "cli/report.h"

#include <cstdio>

namespace evograsp::cli {

int report(const Error& error) {
  std::fprintf(stderr, "evograsp: %s\n", error.message.c_str());
  return static_cast<int>(error.code);
}

int report(const std::vector<Diagnostic>& diagnostics) {
  std::fprintf(stderr, "%s\n", text(diagnostics).c_str());
  return static_cast<int>(ErrorCode::kInvalid);
}

void warn(const std::string& message) {
  std::fprintf(stderr, "evograsp: warning: %s\n", message.c_str());
}

}  // namespace evograsp::cli

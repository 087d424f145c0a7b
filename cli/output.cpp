#include "cli/output.h"

#include <unistd.h>

#include <cstdio>

namespace evograsp::cli {

void print(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
}

void say(const std::string& text) {
  std::fprintf(stderr, "%s\n", text.c_str());
}

bool stdout_is_terminal() {
  return ::isatty(::fileno(stdout)) != 0;
}

void print_document(const std::string& text) {
  print(text + "\n");
  std::fflush(stdout);
}

}  // namespace evograsp::cli

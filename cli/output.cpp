#include "cli/output.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <sstream>

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

// They stand in strings alone, where an escape means the same.
void print_document(const std::string& json) {
  std::string out;
  const auto escape = [&out](unsigned char c) {
    char text[8];
    std::snprintf(text, sizeof text, "\\u%04x", c);
    out += text;
  };
  for (std::size_t i = 0; i < json.size(); ++i) {
    const auto c = static_cast<unsigned char>(json[i]);
    const auto next = i + 1 < json.size() ? static_cast<unsigned char>(json[i + 1]) : 0U;
    if (c == 0x7f) {
      escape(c);
    } else if (c == 0xc2 && next >= 0x80 && next < 0xa0) {
      escape(static_cast<unsigned char>(next));
      ++i;
    } else {
      out += json[i];
    }
  }
  print(out + "\n");
  std::fflush(stdout);
}

TerminalSize terminal_size(std::FILE* out) {
  winsize size{};
  if (::ioctl(::fileno(out), TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {};
  return {size.ws_col, size.ws_row};
}

std::string cut(const std::string& line, int columns) {
  int seen = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool begins = (static_cast<unsigned char>(line[i]) & 0xc0) != 0x80;
    if (begins && ++seen > columns) return line.substr(0, i);
  }
  return line;
}

std::string fit(const std::string& text, TerminalSize size) {
  std::istringstream lines(text);
  std::string out, line;
  for (int row = 0; row < size.rows && std::getline(lines, line); ++row)
    out += (row == 0 ? "" : "\n") + cut(line, size.columns);
  return out;
}

}  // namespace evograsp::cli

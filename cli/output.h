// What a command prints: answers on stdout, as text or (--json) as one JSON document; everything else on
// stderr.
#pragma once

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

namespace evograsp::cli {

// One indented document and a newline on stdout. Bytes that are no UTF-8 are replaced, numbers that are none
// are null, control characters escaped, also those from U+007F to U+009F that JSON would let pass.
template <class Json>
void print_json(const Json& document);
// On one line: for streams of documents.
template <class Json>
void print_json_line(const Json& document);

void print(const std::string& text);  // on stdout, as it is
void say(const std::string& text);    // on stderr, a line

bool stdout_is_terminal();

struct TerminalSize {
  int columns = 80, rows = 24;
};
// As it is now; the usual 80 x 24 when `out` is no terminal.
TerminalSize terminal_size(std::FILE* out);
// The first `columns` characters of UTF-8 text (those this program prints are one column wide).
std::string cut(const std::string& line, int columns);
// At most so many lines of at most so many characters.
std::string fit(const std::string& text, TerminalSize size);

// ---- details ----
void print_document(const std::string& json);

template <class Json>
void print_json(const Json& document) {
  print_document(document.dump(2, ' ', false, Json::error_handler_t::replace));
}
template <class Json>
void print_json_line(const Json& document) {
  print_document(document.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace evograsp::cli

// The reader behind parse_text: protobuf text format, read to the end whatever it finds wrong.
//
// protobuf's own TextFormat::Parser stops at the first complaint and knows nothing of our annotations. This
// one goes on, checks ranges where the value stands, and says what was meant. What it accepts is a subset of
// what TextFormat accepts (no extensions, no Any, no numbers for enum values) and means the same.
#pragma once

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/message.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/config.h"

namespace evograsp {

// Reads one text once. Not thread-safe.
class TextReader : private google::protobuf::io::ErrorCollector {
 public:
  // text must outlive the reader.
  TextReader(std::string_view text, std::string file);

  // Fills message with all that is right in the text; returns what is wrong, in the order of the file.
  std::vector<Diagnostic> read(google::protobuf::Message& message);
  // Where each value stood, by dotted path.
  const Positions& positions() const { return positions_; }

 private:
  using Field = google::protobuf::FieldDescriptor;
  using Message = google::protobuf::Message;
  // Where a value goes: the message and field, and the value's dotted path.
  struct Slot {
    Message& message;
    const Field& field;
    std::string path;
  };

  void AddError(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override;

  void read_fields(Message& message, const std::string& path, std::string_view close, Position opened,
                   int depth);
  void read_field(Message& message, const std::string& path, int depth);
  void unknown_field(const Message& message, const std::string& name, const std::string& path, Position at);
  bool admit(const Slot& slot, Position at);
  void read_values(const Slot& slot, int depth);
  void read_value(const Slot& slot, int depth);
  void read_message(const Slot& slot, int depth);
  void read_scalar(const Slot& slot);
  void read_integer(const Slot& slot);
  void read_real(const Slot& slot);
  void read_bool(const Slot& slot);
  void read_enum(const Slot& slot);
  void read_string(const Slot& slot);
  void check_range(const Slot& slot, double value, const std::string& shown, Position at);
  void check_required(const Message& message, const std::string& path, Position at);

  bool at_end();
  bool looking_at(std::string_view symbol) { return tokenizer_.current().text == symbol && is_symbol(); }
  bool is_symbol();
  bool accept(std::string_view symbol);
  Position here() { return {tokenizer_.current().line + 1, tokenizer_.current().column + 1}; }
  std::string found();
  void skip_value();
  void report(Position at, std::string message);
  void expected(const Slot& slot, const std::string& what);

  std::string file_;
  google::protobuf::io::ArrayInputStream stream_;
  google::protobuf::io::Tokenizer tokenizer_;
  Positions positions_;
  std::vector<Diagnostic> diagnostics_;
};

}  // namespace evograsp

#include "common/text_reader.h"

#include <google/protobuf/descriptor.h>

#include "common/near_miss.h"
#include "proto/options.pb.h"

namespace evograsp {

namespace pb = google::protobuf;
using pb::io::Tokenizer;

namespace {

constexpr int kDeepest = 32;
constexpr std::size_t kMostDiagnostics = 30;

std::vector<std::string> field_names(const pb::Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  return names;
}

std::string join_path(const std::string& path, const std::string& name) {
  return path.empty() ? name : path + "." + name;
}

// "in neat", "at the top level".
std::string place(const std::string& path) {
  return path.empty() ? "at the top level" : "in " + path;
}

// A section of the file that has the key which was looked for elsewhere: "" when none or several have it.
std::string section_with(const pb::Descriptor& top, const std::string& key) {
  std::string found;
  for (int i = 0; i < top.field_count(); ++i) {
    const pb::Descriptor* section = top.field(i)->message_type();
    if (section == nullptr || section->FindFieldByName(key) == nullptr) continue;
    if (!found.empty()) return "";
    found = top.field(i)->name();
  }
  return found;
}

}  // namespace

TextReader::TextReader(std::string_view text, std::string file)
    : file_(std::move(file)),
      stream_(text.data(), static_cast<int>(text.size())),
      tokenizer_(&stream_, this) {
  tokenizer_.set_comment_style(Tokenizer::SH_COMMENT_STYLE);
  tokenizer_.set_allow_f_after_float(true);
}

void TextReader::report(Position at, std::string message) {
  if (diagnostics_.size() < kMostDiagnostics) {
    diagnostics_.push_back({file_, at.line, at.column, std::move(message)});
  } else if (diagnostics_.size() == kMostDiagnostics) {
    diagnostics_.push_back({file_, 0, 0, "too many mistakes: the rest are not shown"});
  }
}

void TextReader::AddError(int line, pb::io::ColumnNumber column, const std::string& message) {
  report({line + 1, column + 1}, message);
}

bool TextReader::is_symbol() {
  return tokenizer_.current().type == Tokenizer::TYPE_SYMBOL;
}

bool TextReader::at_end() {
  return tokenizer_.current().type == Tokenizer::TYPE_END;
}

bool TextReader::accept(std::string_view symbol) {
  if (!looking_at(symbol)) return false;
  tokenizer_.Next();
  return true;
}

std::string TextReader::found() {
  if (at_end()) return "the end of the file";
  const std::string& text = tokenizer_.current().text;
  return text.size() > 40 ? text.substr(0, 37) + "..." : text;
}

std::vector<Diagnostic> TextReader::read(Message& message) {
  tokenizer_.Next();
  read_fields(message, "", "", {1, 1}, 0);
  return std::move(diagnostics_);
}

// The fields of one message, up to and with its closing symbol ("" for the file's own message).
void TextReader::read_fields(Message& message, const std::string& path, std::string_view close,
                             Position opened, int depth) {
  const bool top = close.empty();
  while (!at_end() && (top || !looking_at(close))) {
    if (tokenizer_.current().type == Tokenizer::TYPE_IDENTIFIER) {
      read_field(message, path, depth);
      if (!accept(",")) accept(";");
      continue;
    }
    report(here(), "expected a key " + place(path) + ", found " + found());
    for (const int line = here().line; !at_end() && here().line == line && !looking_at(close);)
      tokenizer_.Next();
  }
  if (!top && !accept(close)) report(opened, "'" + path + "' is opened here and never closed");
  check_required(message, path, top ? Position{} : opened);
}

void TextReader::read_field(Message& message, const std::string& path, int depth) {
  const Position at = here();
  const std::string name = tokenizer_.current().text;
  tokenizer_.Next();
  const Field* field = message.GetDescriptor()->FindFieldByName(name);
  if (field == nullptr) {
    unknown_field(message, name, path, at);
    accept(":");
    skip_value();
    return;
  }
  const Slot slot{message, *field, join_path(path, name)};
  const bool is_message = field->cpp_type() == Field::CPPTYPE_MESSAGE;
  if (!accept(":") && !is_message) report(here(), "expected ':' after '" + name + "', found " + found());
  if (!admit(slot, at)) {
    skip_value();
    return;
  }
  read_values(slot, depth);
}

void TextReader::unknown_field(const Message& message, const std::string& name, const std::string& path,
                               Position at) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const auto known = field_names(type);
  std::string advice = did_you_mean(name, known);
  if (advice.empty()) {
    const std::string section = path.empty() ? section_with(type, name) : "";
    advice =
        section.empty() ? "; allowed are " + join_words(known, 50) : ": it belongs into " + section + " { }";
  }
  report(at, "unknown key '" + name + "' " + place(path) + advice);
}

// Whether the field may be given here: not twice, and not beside another of the same choice.
bool TextReader::admit(const Slot& slot, Position at) {
  if (slot.field.is_repeated()) return true;
  const auto [earlier, fresh] = positions_.emplace(slot.path, at);
  if (!fresh) {
    report(at, "'" + slot.path + "' was already given on line " + std::to_string(earlier->second.line));
    return false;
  }
  const pb::OneofDescriptor* choice = slot.field.real_containing_oneof();
  const Field* other = choice == nullptr
                           ? nullptr
                           : slot.message.GetReflection()->GetOneofFieldDescriptor(slot.message, choice);
  if (other == nullptr) return true;
  report(at, "'" + slot.field.name() + "' and '" + other->name() + "' exclude each other: give one " +
                 choice->name());
  return false;
}

// One value, or a list of them in brackets.
void TextReader::read_values(const Slot& slot, int depth) {
  if (!looking_at("[")) {
    read_value(slot, depth);
    return;
  }
  const Position opened = here();
  if (!slot.field.is_repeated()) {
    report(opened, "'" + slot.path + "' takes one value, not a list");
    skip_value();
    return;
  }
  tokenizer_.Next();
  while (!at_end() && !looking_at("]")) {
    read_value(slot, depth);
    if (looking_at("]") || at_end()) break;
    if (accept(",")) {
      if (looking_at("]")) report(here(), "expected a value after ',' in the list '" + slot.path + "'");
      continue;
    }
    report(here(), "expected ',' or ']' in the list '" + slot.path + "', found " + found());
    while (!at_end() && !looking_at("]") && !looking_at(",") && !looking_at("}")) tokenizer_.Next();
    if (!accept(",")) break;
  }
  if (!accept("]") && at_end())
    report(opened, "the list '" + slot.path + "' is opened here and never closed");
}

void TextReader::read_value(const Slot& slot, int depth) {
  if (!slot.field.is_repeated()) {
    if (slot.field.cpp_type() == Field::CPPTYPE_MESSAGE) {
      read_message(slot, depth);
    } else {
      positions_[slot.path] = here();
      read_scalar(slot);
    }
    return;
  }
  const int index = slot.message.GetReflection()->FieldSize(slot.message, &slot.field);
  const Slot element{slot.message, slot.field, slot.path + "[" + std::to_string(index) + "]"};
  positions_[element.path] = here();
  if (slot.field.cpp_type() == Field::CPPTYPE_MESSAGE) {
    read_message(element, depth);
  } else {
    read_scalar(element);
  }
}

void TextReader::read_message(const Slot& slot, int depth) {
  const Position opened = here();
  const bool angle = looking_at("<");
  if (!angle && !looking_at("{")) {
    expected(slot, "'{'");
    return;
  }
  if (depth >= kDeepest) {
    report(opened, "nested deeper than " + std::to_string(kDeepest) + " levels");
    skip_value();
    return;
  }
  tokenizer_.Next();
  const pb::Reflection& reflection = *slot.message.GetReflection();
  Message* inner = slot.field.is_repeated() ? reflection.AddMessage(&slot.message, &slot.field)
                                            : reflection.MutableMessage(&slot.message, &slot.field);
  read_fields(*inner, slot.path, angle ? ">" : "}", opened, depth + 1);
}

void TextReader::check_required(const Message& message, const std::string& path, Position at) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const pb::Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const Field& field = *type.field(i);
    if (!field.options().GetExtension(proto::required_field)) continue;
    const std::string name = join_path(path, field.name());
    const bool given = field.is_repeated()
                           ? reflection.FieldSize(message, &field) > 0
                           : reflection.HasField(message, &field) || positions_.contains(name);
    if (!given) report(at, "'" + name + "' is missing: it has no default");
  }
}

// Leaves a value that nobody wants: a scalar, or everything up to the matching bracket.
void TextReader::skip_value() {
  int depth = 0;
  do {
    if (at_end()) return;
    const bool opens = looking_at("{") || looking_at("<") || looking_at("[");
    const bool closes = looking_at("}") || looking_at(">") || looking_at("]");
    if (closes && depth == 0) return;
    depth += opens ? 1 : closes ? -1 : 0;
    const bool minus = looking_at("-");
    const bool string = tokenizer_.current().type == Tokenizer::TYPE_STRING;
    tokenizer_.Next();
    if (depth == 0 && minus && !at_end() && !is_symbol()) tokenizer_.Next();
    while (depth == 0 && string && tokenizer_.current().type == Tokenizer::TYPE_STRING) tokenizer_.Next();
  } while (depth > 0);
}

void TextReader::expected(const Slot& slot, const std::string& what) {
  report(here(), "'" + slot.path + "' takes " + what + ", found " + found());
  skip_value();
}

}  // namespace evograsp

// The scalar half of TextReader: numbers, switches, names and strings, each with what is allowed.
#include <google/protobuf/descriptor.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/near_miss.h"
#include "common/text_reader.h"
#include "common/utf8.h"
#include "proto/options.pb.h"

namespace evograsp {

namespace pb = google::protobuf;
using pb::io::Tokenizer;

namespace {

// What no range says otherwise: nothing that is measured or counted here comes near, and squares and products
// of such numbers stay finite.
constexpr double kLargestNumber = 1e9;

// The shortest decimal text that reads back as the same double.
std::string shortest(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

// "at least 0 m", "between 0 and 1", "above 0".
std::string allowed_range(const pb::FieldOptions& options) {
  const std::string unit = options.HasExtension(proto::unit) ? " " + options.GetExtension(proto::unit) : "";
  const bool has_min = options.HasExtension(proto::min), has_max = options.HasExtension(proto::max);
  const std::string min = shortest(options.GetExtension(proto::min));
  const std::string max = shortest(options.GetExtension(proto::max));
  const bool above = options.GetExtension(proto::above_min);
  if (has_min && has_max)
    return above ? "above " + min + " and at most " + max + unit : "from " + min + " to " + max + unit;
  if (has_min) return (above ? "above " : "at least ") + min + unit;
  return "at most " + max + unit;
}

}  // namespace

void TextReader::read_scalar(const Slot& slot) {
  switch (slot.field.cpp_type()) {
    case Field::CPPTYPE_INT32:
    case Field::CPPTYPE_INT64:
    case Field::CPPTYPE_UINT32:
    case Field::CPPTYPE_UINT64:
      return read_integer(slot);
    case Field::CPPTYPE_DOUBLE:
    case Field::CPPTYPE_FLOAT:
      return read_real(slot);
    case Field::CPPTYPE_BOOL:
      return read_bool(slot);
    case Field::CPPTYPE_ENUM:
      return read_enum(slot);
    default:
      return read_string(slot);
  }
}

void TextReader::check_range(const Slot& slot, double value, const std::string& shown, Position at) {
  const pb::FieldOptions& options = slot.field.options();
  const bool has_min = options.HasExtension(proto::min), has_max = options.HasExtension(proto::max);
  const double min = options.GetExtension(proto::min), max = options.GetExtension(proto::max);
  const bool low = has_min && (options.GetExtension(proto::above_min) ? value <= min : value < min);
  if (low || (has_max && value > max)) {
    report(at, "'" + slot.path + "' is " + shown + ", allowed is " + allowed_range(options));
  }
}

void TextReader::read_integer(const Slot& slot) {
  const Position at = here();
  const bool negative = accept("-");
  if (tokenizer_.current().type != Tokenizer::TYPE_INTEGER) return expected(slot, "a whole number");
  const std::string shown = (negative ? "-" : "") + tokenizer_.current().text;
  std::uint64_t magnitude = 0;
  const bool fits = Tokenizer::ParseInteger(tokenizer_.current().text,
                                            std::numeric_limits<std::uint64_t>::max(), &magnitude);
  tokenizer_.Next();

  const auto type = slot.field.cpp_type();
  const bool is_signed = type == Field::CPPTYPE_INT32 || type == Field::CPPTYPE_INT64;
  const bool wide = type == Field::CPPTYPE_INT64 || type == Field::CPPTYPE_UINT64;
  const std::uint64_t largest =
      (wide ? std::numeric_limits<std::uint64_t>::max() : 0xffffffffULL) >> (is_signed ? 1 : 0);
  if (negative && !is_signed && magnitude != 0) {
    return report(at, "'" + slot.path + "' is " + shown + ", negative numbers are not allowed");
  }
  if (!fits || magnitude > largest) {
    return report(at, "'" + slot.path + "' is " + shown + ", allowed is at most " + std::to_string(largest));
  }
  check_range(slot, (negative ? -1.0 : 1.0) * static_cast<double>(magnitude), shown, at);

  const pb::Reflection& set = *slot.message.GetReflection();
  const bool add = slot.field.is_repeated();
  const auto value = negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
  Message* m = &slot.message;
  const Field* f = &slot.field;
  if (type == Field::CPPTYPE_INT32) {
    add ? set.AddInt32(m, f, static_cast<std::int32_t>(value))
        : set.SetInt32(m, f, static_cast<std::int32_t>(value));
  } else if (type == Field::CPPTYPE_INT64) {
    add ? set.AddInt64(m, f, value) : set.SetInt64(m, f, value);
  } else if (type == Field::CPPTYPE_UINT32) {
    add ? set.AddUInt32(m, f, static_cast<std::uint32_t>(magnitude))
        : set.SetUInt32(m, f, static_cast<std::uint32_t>(magnitude));
  } else {
    add ? set.AddUInt64(m, f, magnitude) : set.SetUInt64(m, f, magnitude);
  }
}

void TextReader::read_real(const Slot& slot) {
  const Position at = here();
  const bool negative = accept("-");
  const auto token = tokenizer_.current();
  const bool is_number = token.type == Tokenizer::TYPE_FLOAT || token.type == Tokenizer::TYPE_INTEGER;
  const bool is_decimal = token.text.find_first_of("xX") == std::string::npos;
  if (!is_number || !is_decimal) return expected(slot, "a number");
  const double value = (negative ? -1.0 : 1.0) * Tokenizer::ParseFloat(token.text);
  tokenizer_.Next();
  const bool single = slot.field.cpp_type() == Field::CPPTYPE_FLOAT;
  if (!(std::abs(value) <= kLargestNumber)) {
    return report(at, "'" + slot.path + "' is too large a number: at most 1e9 is allowed");
  }
  check_range(slot, value, (negative ? "-" : "") + token.text, at);

  const pb::Reflection& set = *slot.message.GetReflection();
  Message* m = &slot.message;
  const Field* f = &slot.field;
  if (single) {
    const auto narrow = static_cast<float>(value);
    f->is_repeated() ? set.AddFloat(m, f, narrow) : set.SetFloat(m, f, narrow);
  } else {
    f->is_repeated() ? set.AddDouble(m, f, value) : set.SetDouble(m, f, value);
  }
}

void TextReader::read_bool(const Slot& slot) {
  const std::string& text = tokenizer_.current().text;
  const bool is_true = text == "true" || text == "True" || text == "t" || text == "1";
  const bool is_false = text == "false" || text == "False" || text == "f" || text == "0";
  if (!is_true && !is_false) return expected(slot, "true or false");
  tokenizer_.Next();
  const pb::Reflection& set = *slot.message.GetReflection();
  slot.field.is_repeated() ? set.AddBool(&slot.message, &slot.field, is_true)
                           : set.SetBool(&slot.message, &slot.field, is_true);
}

void TextReader::read_enum(const Slot& slot) {
  const pb::EnumDescriptor& type = *slot.field.enum_type();
  const std::string text = tokenizer_.current().text;
  const pb::EnumValueDescriptor* value = type.FindValueByName(text);
  if (value == nullptr) {
    std::vector<std::string> names;
    for (int i = 0; i < type.value_count(); ++i) names.push_back(type.value(i)->name());
    const std::string advice = did_you_mean(text, names);
    report(here(), "'" + slot.path + "' is " + found() + ", allowed are " + join_words(names, 50) + advice);
    return skip_value();
  }
  tokenizer_.Next();
  const pb::Reflection& set = *slot.message.GetReflection();
  slot.field.is_repeated() ? set.AddEnum(&slot.message, &slot.field, value)
                           : set.SetEnum(&slot.message, &slot.field, value);
}

void TextReader::read_string(const Slot& slot) {
  if (tokenizer_.current().type != Tokenizer::TYPE_STRING) return expected(slot, "text in quotes");
  const Position at = here();
  std::string value;
  while (tokenizer_.current().type == Tokenizer::TYPE_STRING) {
    Tokenizer::ParseStringAppend(tokenizer_.current().text, &value);
    tokenizer_.Next();
  }
  if (slot.field.type() == Field::TYPE_STRING && first_non_text(value)) {
    return report(at, "'" + slot.path + "' is not UTF-8 text");
  }
  const pb::Reflection& set = *slot.message.GetReflection();
  slot.field.is_repeated() ? set.AddString(&slot.message, &slot.field, value)
                           : set.SetString(&slot.message, &slot.field, value);
}

}  // namespace evograsp

// The values of a config message: defaults written out, leaves listed.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/text_format.h>

#include "common/config.h"
#include "proto/options.pb.h"

namespace evograsp {

namespace pb = google::protobuf;
using Field = pb::FieldDescriptor;

namespace {

void write_scalar_default(pb::Message& message, const Field& field) {
  const pb::Reflection& set = *message.GetReflection();
  switch (field.cpp_type()) {
    case Field::CPPTYPE_INT32:
      return set.SetInt32(&message, &field, field.default_value_int32());
    case Field::CPPTYPE_INT64:
      return set.SetInt64(&message, &field, field.default_value_int64());
    case Field::CPPTYPE_UINT32:
      return set.SetUInt32(&message, &field, field.default_value_uint32());
    case Field::CPPTYPE_UINT64:
      return set.SetUInt64(&message, &field, field.default_value_uint64());
    case Field::CPPTYPE_DOUBLE:
      return set.SetDouble(&message, &field, field.default_value_double());
    case Field::CPPTYPE_FLOAT:
      return set.SetFloat(&message, &field, field.default_value_float());
    case Field::CPPTYPE_BOOL:
      return set.SetBool(&message, &field, field.default_value_bool());
    case Field::CPPTYPE_ENUM:
      return set.SetEnum(&message, &field, field.default_value_enum());
    case Field::CPPTYPE_STRING:
      return set.SetString(&message, &field, field.default_value_string());
    case Field::CPPTYPE_MESSAGE:
      return;
  }
}

// Merges what is given over the default, so that a component left out keeps its default.
void write_message_default(pb::Message& message, const Field& field, const std::string& text) {
  const pb::Reflection& reflection = *message.GetReflection();
  if (field.is_repeated()) {
    if (reflection.FieldSize(message, &field) > 0) return;
    pb::TextFormat::ParseFromString(text, reflection.AddMessage(&message, &field));
    return;
  }
  pb::Message* inner = reflection.MutableMessage(&message, &field);
  std::unique_ptr<pb::Message> whole(inner->New());
  pb::TextFormat::ParseFromString(text, whole.get());
  whole->MergeFrom(*inner);
  inner->CopyFrom(*whole);
}

// Sections of the file exist even when nobody writes them; deeper messages only when somebody does.
bool is_section(const Field& field) {
  static const std::string kTop = proto::Config::descriptor()->full_name();
  return field.containing_type()->full_name() == kTop && !field.is_repeated();
}

std::string value_text(const pb::Message& message, const Field& field, int index) {
  std::string text;
  pb::TextFormat::Printer printer;
  printer.SetUseUtf8StringEscaping(true);
  printer.PrintFieldValueToString(message, &field, index, &text);
  return text;
}

using Leaves = std::vector<std::pair<std::string, std::string>>;

void flatten_into(const pb::Message& message, const std::string& prefix, Leaves& leaves) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const pb::Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const Field& field = *type.field(i);
    const std::string path = prefix + field.name();
    const bool is_message = field.cpp_type() == Field::CPPTYPE_MESSAGE;
    if (field.is_repeated()) {
      for (int k = 0; k < reflection.FieldSize(message, &field); ++k) {
        const std::string element = path + "[" + std::to_string(k) + "]";
        if (is_message) {
          flatten_into(reflection.GetRepeatedMessage(message, &field, k), element + ".", leaves);
        } else {
          leaves.emplace_back(element, value_text(message, field, k));
        }
      }
    } else if (is_message) {
      if (reflection.HasField(message, &field))
        flatten_into(reflection.GetMessage(message, &field), path + ".", leaves);
    } else if (reflection.HasField(message, &field) || field.has_default_value()) {
      leaves.emplace_back(path, value_text(message, field, -1));
    }
  }
}

}  // namespace

void write_defaults(pb::Message& message) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const pb::Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const Field& field = *type.field(i);
    if (field.cpp_type() != Field::CPPTYPE_MESSAGE) {
      const bool wanted =
          !field.is_repeated() && field.has_default_value() && field.real_containing_oneof() == nullptr;
      if (wanted && !reflection.HasField(message, &field)) write_scalar_default(message, field);
      continue;
    }
    if (field.options().HasExtension(proto::default_text)) {
      write_message_default(message, field, field.options().GetExtension(proto::default_text));
    }
    if (field.is_repeated()) {
      for (int k = 0; k < reflection.FieldSize(message, &field); ++k) {
        write_defaults(*reflection.MutableRepeatedMessage(&message, &field, k));
      }
    } else if (is_section(field) || reflection.HasField(message, &field)) {
      write_defaults(*reflection.MutableMessage(&message, &field));
    }
  }
}

Leaves flatten(const pb::Message& message) {
  Leaves leaves;
  flatten_into(message, "", leaves);
  return leaves;
}

}  // namespace evograsp

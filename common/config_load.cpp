// load_config: one config out of flags, environment, file and defaults, with the origin of each value.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/stubs/strutil.h>

#include <algorithm>
#include <memory>

#include "common/config.h"
#include "common/config_check.h"
#include "common/near_miss.h"
#include "proto/options.pb.h"

extern char** environ;

namespace evograsp {

namespace fs = std::filesystem;
namespace pb = google::protobuf;
using Field = pb::FieldDescriptor;

namespace {

constexpr std::string_view kPrefix = "EVOGRASP_";

struct Override {
  std::string path, value, label;  // label: how the user gave it, for diagnostics
  Origin origin;
};

bool is_below(const std::string& leaf, const std::string& path) {
  if (!leaf.starts_with(path)) return false;
  return leaf.size() == path.size() || leaf[path.size()] == '.' || leaf[path.size()] == '[';
}

// EVOGRASP_NEAT__POPULATION=200 -> neat.population=200. Only names with a double underscore are config keys.
std::vector<Override> from_environment() {
  std::vector<Override> found;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const std::size_t equals = text.find('=');
    const std::string_view name = text.substr(0, equals);
    if (equals == std::string_view::npos || !name.starts_with(kPrefix) || name.find("__") == name.npos)
      continue;
    std::string path;
    for (std::size_t i = kPrefix.size(); i < name.size(); ++i) {
      const bool separator = name[i] == '_' && i + 1 < name.size() && name[i + 1] == '_';
      const bool upper = name[i] >= 'A' && name[i] <= 'Z';
      path += separator ? '.' : upper ? static_cast<char>(name[i] - 'A' + 'a') : name[i];
      if (separator) ++i;
    }
    found.push_back({path, std::string(text.substr(equals + 1)), "environment " + std::string(name),
                     Origin::kEnvironment});
  }
  std::sort(found.begin(), found.end(),
            [](const Override& a, const Override& b) { return a.label < b.label; });
  return found;
}

std::string in_quotes(std::string_view text) {
  return "\"" + pb::CEscape(std::string(text)) + "\"";
}

// The value of a flag as text format: words need no quotes, lists need no brackets.
std::string as_text_format(const Field& field, const std::string& value) {
  const bool is_string = field.cpp_type() == Field::CPPTYPE_STRING;
  if (!field.is_repeated()) return is_string && !value.starts_with('"') ? in_quotes(value) : value;
  if (value.starts_with('[') || field.cpp_type() == Field::CPPTYPE_MESSAGE) return value;
  std::string list;
  for (std::size_t from = 0; from <= value.size() && !value.empty();) {
    const std::size_t comma = std::min(value.find(',', from), value.size());
    const std::string_view element = std::string_view(value).substr(from, comma - from);
    list += (list.empty() ? "" : ", ") +
            (is_string && !element.starts_with('"') ? in_quotes(element) : std::string(element));
    from = comma + 1;
  }
  return "[" + list + "]";
}

class Loader {
 public:
  Loader(const std::vector<std::string>& overrides, const KnownNames& names)
      : flags_(overrides), names_(names) {}
  tl::expected<LoadedConfig, std::vector<Diagnostic>> load(const std::string& file);

 private:
  bool read(const std::string& file);
  std::vector<Override> from_flags();
  void apply(const Override& change);
  std::vector<const Field*> find(const Override& change);
  void complain(const std::string& path, const std::string& message);
  Origin origin_of(const std::string& leaf) const;
  void check_paths(pb::Message& message, const std::string& prefix);
  void check_path(const std::string& key, const std::string& path, std::string& value);

  const std::vector<std::string>& flags_;
  const KnownNames& names_;
  std::string file_;
  LoadedConfig result_;
  std::vector<Override> applied_;
  std::vector<Diagnostic> diagnostics_;
};

// A file of that name, else a built-in config.
bool Loader::read(const std::string& file) {
  std::error_code error;
  const auto builtin = builtin_config(file);
  std::string text;
  if (builtin && !fs::is_regular_file(file, error)) {
    file_ = file + " (built in)";
    text = *builtin;
    result_.config.mutable_run()->set_name(file);
  } else {
    file_ = file;
    auto data = read_file(file);
    if (!data) {
      std::string message = data.error().message;
      if (data.error().code == ErrorCode::kNotFound) {
        message +=
            "; built-in configs are " + join_words(builtin_configs()) + did_you_mean(file, builtin_configs());
      }
      diagnostics_.push_back({file, 0, 0, message.substr(file.size() + 2)});
      return false;
    }
    text = std::move(*data);
    result_.base = fs::path(file).parent_path();
  }
  diagnostics_ = parse_text(text, file_, result_.config, &result_.positions);
  if (!result_.config.run().has_name()) {
    result_.config.mutable_run()->set_name(fs::path(file).stem().string());
  }
  return true;
}

std::vector<Override> Loader::from_flags() {
  std::vector<Override> found;
  for (const std::string& flag : flags_) {
    const std::size_t equals = flag.find('=');
    if (equals == std::string::npos || equals == 0) {
      diagnostics_.push_back({"--set " + flag, 0, 0, "expected KEY=VALUE, e.g. neat.population=200"});
      continue;
    }
    const std::string path = flag.substr(0, equals);
    found.push_back({path, flag.substr(equals + 1), "--set " + path, Origin::kFlag});
  }
  return found;
}

// The fields on the way to a dotted path; empty (and a diagnostic) when there is no such key.
std::vector<const Field*> Loader::find(const Override& change) {
  const pb::Descriptor* type = proto::Config::descriptor();
  std::vector<const Field*> way;
  for (std::size_t from = 0; from <= change.path.size();) {
    const std::size_t dot = std::min(change.path.find('.', from), change.path.size());
    const std::string name = change.path.substr(from, dot - from);
    std::vector<std::string> known;
    for (int i = 0; type != nullptr && i < type->field_count(); ++i) known.push_back(type->field(i)->name());
    const bool into_list = !way.empty() && way.back()->is_repeated();
    const Field* field = type == nullptr || into_list ? nullptr : type->FindFieldByName(name);
    if (field == nullptr) {
      const std::string prefix = change.path.substr(0, from == 0 ? 0 : from - 1);
      const std::string meant = did_you_mean(name, known);
      std::string advice =
          meant.empty() && !known.empty() && !into_list ? "; allowed are " + join_words(known, 50) : meant;
      if (into_list) advice = "; a list is replaced as a whole: " + prefix + "=...";
      const std::string place = prefix.empty() ? "at the top level" : "in " + prefix;
      diagnostics_.push_back({change.label, 0, 0, "unknown key '" + name + "' " + place + advice});
      return {};
    }
    way.push_back(field);
    type = field->message_type();
    from = dot + 1;
  }
  return way;
}

void Loader::apply(const Override& change) {
  const std::vector<const Field*> way = find(change);
  if (way.empty()) return;
  const bool is_message = way.back()->cpp_type() == Field::CPPTYPE_MESSAGE;
  std::string text = as_text_format(*way.back(), change.value);
  if (is_message && !text.starts_with('{') && !text.starts_with('[')) text = "{ " + text + " }";
  text = way.back()->name() + ": " + text;
  for (std::size_t i = way.size() - 1; i-- > 0;) text = way[i]->name() + " { " + text + " }";

  proto::Config given;
  Positions where;
  const auto mistakes = parse_text(text, change.label, given, &where);
  for (const Diagnostic& mistake : mistakes) diagnostics_.push_back({change.label, 0, 0, mistake.message});
  if (!mistakes.empty()) return;
  for (const auto& [leaf, position] : where) {
    if (is_below(leaf, change.path) || is_below(change.path, leaf)) continue;
    diagnostics_.push_back({change.label, 0, 0, "expected one value, found '" + change.value + "'"});
    return;
  }
  pb::Message* target = &result_.config;
  for (std::size_t i = 0; i + 1 < way.size(); ++i)
    target = target->GetReflection()->MutableMessage(target, way[i]);
  target->GetReflection()->ClearField(target, way.back());
  result_.config.MergeFrom(given);
  applied_.push_back(change);
}

Origin Loader::origin_of(const std::string& leaf) const {
  for (auto change = applied_.rbegin(); change != applied_.rend(); ++change) {
    if (is_below(leaf, change->path)) return change->origin;
  }
  return result_.positions.contains(leaf) ? Origin::kFile : Origin::kDefault;
}

// A complaint about a value, at the place that gave it.
void Loader::complain(const std::string& path, const std::string& message) {
  for (auto change = applied_.rbegin(); change != applied_.rend(); ++change) {
    if (!is_below(path, change->path)) continue;
    diagnostics_.push_back({change->label, 0, 0, "'" + path + "': " + message});
    return;
  }
  const auto at = result_.positions.find(path);
  const Position position = at == result_.positions.end() ? Position{} : at->second;
  diagnostics_.push_back({file_, position.line, position.column, "'" + path + "': " + message});
}

// A name that is neither known nor a file. Files that flags and the environment name are found from the
// working folder.
void Loader::check_path(const std::string& key, const std::string& path, std::string& value) {
  const auto known = names_.find(key);
  if (known != names_.end() && std::ranges::find(known->second, value) != known->second.end()) return;
  const bool is_name = value.find('/') == std::string::npos && value.find('.') == std::string::npos;
  if (is_name && known == names_.end()) return;
  const Origin origin = origin_of(path);
  const bool from_shell = origin == Origin::kFlag || origin == Origin::kEnvironment;
  std::error_code error;
  const fs::path file = from_shell ? fs::absolute(value, error) : result_.base / value;
  if (!fs::is_regular_file(file, error)) {
    std::string advice = known == names_.end() ? "" : did_you_mean(value, known->second);
    if (advice.empty() && known != names_.end()) advice = "; built in are " + join_words(known->second);
    complain(path, (is_name ? "no file and nothing built in is named '" : "no such file: '") + value + "'" +
                       advice);
  } else if (from_shell) {
    value = file.lexically_normal().string();
  }
}

void Loader::check_paths(pb::Message& message, const std::string& prefix) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const pb::Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const Field& field = *type.field(i);
    const std::string key = prefix + field.name();
    if (field.cpp_type() == Field::CPPTYPE_MESSAGE && !field.is_repeated()) {
      if (reflection.HasField(message, &field))
        check_paths(*reflection.MutableMessage(&message, &field), key + ".");
    }
    if (!field.options().GetExtension(proto::path)) continue;
    const int count = field.is_repeated() ? reflection.FieldSize(message, &field) : 1;
    for (int k = 0; k < count; ++k) {
      std::string value = field.is_repeated() ? reflection.GetRepeatedString(message, &field, k)
                                              : reflection.GetString(message, &field);
      check_path(key, field.is_repeated() ? key + "[" + std::to_string(k) + "]" : key, value);
      field.is_repeated() ? reflection.SetRepeatedString(&message, &field, k, value)
                          : reflection.SetString(&message, &field, value);
    }
  }
}

// The input sheet of a HyperNEAT substrate is the camera's, unless somebody names another (which check_config
// refuses).
void follow_camera(proto::Config& config) {
  if (!config.neat().has_hyperneat()) return;
  proto::HyperNeatConfig& substrate = *config.mutable_neat()->mutable_hyperneat();
  if (!substrate.has_input_columns()) substrate.set_input_columns(config.camera().columns());
  if (!substrate.has_input_rows()) substrate.set_input_rows(config.camera().rows());
}

tl::expected<LoadedConfig, std::vector<Diagnostic>> Loader::load(const std::string& file) {
  if (!read(file)) return tl::unexpected(diagnostics_);
  for (const Override& change : from_environment()) apply(change);
  for (const Override& change : from_flags()) apply(change);
  follow_camera(result_.config);
  write_defaults(result_.config);
  // Contradictions are looked for between values that are right by themselves.
  if (diagnostics_.empty()) {
    check_paths(result_.config, "");
    check_config(result_.config, [this](const auto& path, const auto& message) { complain(path, message); });
  }
  if (!diagnostics_.empty()) return tl::unexpected(diagnostics_);
  for (const auto& [leaf, value] : flatten(result_.config)) result_.origin[leaf] = origin_of(leaf);
  result_.file = file_;
  return std::move(result_);
}

}  // namespace

tl::expected<LoadedConfig, std::vector<Diagnostic>> load_config(const std::string& file,
                                                                const std::vector<std::string>& overrides,
                                                                const KnownNames& names) {
  return Loader(overrides, names).load(file);
}

}  // namespace evograsp

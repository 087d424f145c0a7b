#include "cli/queries.h"

#include <limits>

#include "cli/table.h"

namespace evograsp::cli {

void add_queries(CLI::App& app, Outcome& outcome) {
  add_status(app, outcome);
  add_lists(app, outcome);
  add_champion(app, outcome);
  add_archive(app, outcome);
  add_runs(app, outcome);
  add_steering(app, outcome);
}

const nlohmann::json& part_in(const nlohmann::json& document, const char* key) {
  static const nlohmann::json kNone;
  const auto found = document.find(key);
  return found != document.end() ? *found : kNone;
}

double number_in(const nlohmann::json& document, const char* key) {
  const nlohmann::json& part = part_in(document, key);
  return part.is_number() ? part.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string text_in(const nlohmann::json& document, const char* key) {
  const nlohmann::json& part = part_in(document, key);
  return part.is_string() ? printable(part.get_ref<const std::string&>()) : "";
}

std::uint64_t count_in(const nlohmann::json& document, const char* key) {
  const nlohmann::json& part = part_in(document, key);
  return part.is_number_unsigned() ? part.get<std::uint64_t>() : 0;
}

bool flag_in(const nlohmann::json& document, const char* key) {
  return part_in(document, key) == true;
}

nlohmann::json rows_in(const nlohmann::json& document, const char* key) {
  const nlohmann::json& part = part_in(document, key);
  return part.is_array() ? part : nlohmann::json::array();
}

}  // namespace evograsp::cli

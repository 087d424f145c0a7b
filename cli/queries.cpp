#include "cli/queries.h"

#include <limits>

namespace evograsp::cli {

void add_queries(CLI::App& app, Outcome& outcome) {
  add_status(app, outcome);
  add_lists(app, outcome);
  add_champion(app, outcome);
  add_archive(app, outcome);
  add_runs(app, outcome);
  add_steering(app, outcome);
}

double number_in(const nlohmann::json& document, const char* key) {
  const auto found = document.find(key);
  return found != document.end() && found->is_number() ? found->get<double>()
                                                       : std::numeric_limits<double>::quiet_NaN();
}

std::string text_in(const nlohmann::json& document, const char* key) {
  const auto found = document.find(key);
  return found != document.end() && found->is_string() ? found->get<std::string>() : "";
}

std::uint64_t count_in(const nlohmann::json& document, const char* key) {
  const auto found = document.find(key);
  return found != document.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

}  // namespace evograsp::cli

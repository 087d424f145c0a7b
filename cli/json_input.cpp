#include "cli/json_input.h"

#include <set>
#include <string>
#include <vector>

namespace evograsp::cli {

using nlohmann::json;

json parse_json(std::string_view text, Duplicates duplicates) {
  bool refused = false;
  std::vector<std::set<std::string>> open;  // keys so far, of each level
  const json::parser_callback_t look = [&](int depth, json::parse_event_t event, json& parsed) {
    switch (event) {
      case json::parse_event_t::object_start:
      case json::parse_event_t::array_start:
        if (depth >= kDeepestJson) refused = true;
        if (!refused) open.emplace_back();
        break;
      case json::parse_event_t::object_end:
      case json::parse_event_t::array_end:
        if (!refused) open.pop_back();
        break;
      case json::parse_event_t::key:
        if (!refused && duplicates == Duplicates::kRefuse)
          refused = !open.back().insert(parsed.get<std::string>()).second;
        break;
      case json::parse_event_t::value:
        break;
    }
    return !refused;
  };
  json document = json::parse(text, look, false);
  return refused ? json(json::value_t::discarded) : document;
}

}  // namespace evograsp::cli

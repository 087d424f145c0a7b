// JSON that others wrote.
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace evograsp::cli {

inline constexpr int kDeepestJson = 32;  // levels; what handles a document calls itself once a level

enum class Duplicates { kLast, kRefuse };  // of a key in one object: the last one counts, or none

// The document, or a discarded value (is_discarded()) for text that is not JSON, is nested deeper than
// kDeepestJson or, if asked for, has a key twice in one object. Never throws.
nlohmann::json parse_json(std::string_view text, Duplicates duplicates = Duplicates::kLast);

}  // namespace evograsp::cli

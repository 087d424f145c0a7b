#include "server/api_request.h"

#include <charconv>
#include <nlohmann/json.hpp>

#include "server/api_access.h"

namespace evograsp::server {

using httplib::Request;
using nlohmann::json;

[[noreturn]] void bad(const std::string& message) {
  throw HttpError{400, "invalid", message};
}

std::uint64_t query_number(const Request& request, const char* name, std::uint64_t absent,
                           std::uint64_t most) {
  if (!request.has_param(name)) return absent;
  const std::string text = request.get_param_value(name);
  std::uint64_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size() || value > most)
    bad(std::string(name) + ": a whole number from 0 to " + std::to_string(most) + " is needed, not '" +
        text + "'");
  return value;
}

void allow_only(const Request& request, const std::set<std::string>& names) {
  for (const auto& [name, value] : request.params)
    if (!names.contains(name)) bad("unknown query parameter '" + name + "'");
}

std::string body_text(const Request& request, const char* name) {
  const json body = json::parse(request.body, nullptr, false);
  if (!body.is_object() || body.size() != 1 || !body.contains(name) || !body[name].is_string())
    bad(std::string("a body like {\"") + name + "\": \"...\"} is needed");
  return body[name];
}

bool is_trick(const std::string& path) {
  return path.find("..") != std::string::npos || path.find("//") != std::string::npos ||
         path.find('\\') != std::string::npos || path.find('\0') != std::string::npos;
}

std::string as_pattern(const std::string& path) {
  std::string pattern;
  for (const char c : path) {
    if (std::string_view("\\^$.|?*+()[]{}").find(c) != std::string_view::npos) pattern.push_back('\\');
    pattern.push_back(c);
  }
  return pattern;
}

}  // namespace evograsp::server

// What a request to the HTTP API says, or an HttpError of status 400 that tells why it says nothing.
#pragma once

#include <httplib.h>

#include <cstdint>
#include <set>
#include <string>

namespace evograsp::server {

[[noreturn]] void bad(const std::string& message);

// A whole number in a query, within [0, most].
std::uint64_t query_number(const httplib::Request& request, const char* name, std::uint64_t absent,
                           std::uint64_t most);
void allow_only(const httplib::Request& request, const std::set<std::string>& names);
// The one value of a body like {"level": "debug"}.
std::string body_text(const httplib::Request& request, const char* name);

// What nobody asks who only follows links: "/../../etc/passwd", "//etc/passwd".
bool is_trick(const std::string& path);
// The regular expression that matches this path alone.
std::string as_pattern(const std::string& path);

}  // namespace evograsp::server

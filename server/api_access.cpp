#include "server/api_access.h"

#include <sodium.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "common/utf8.h"
#include "server/api.h"
#include "server/api_http.h"

namespace evograsp::server {
namespace {

using httplib::Request;

constexpr std::size_t kShortestToken = 16, kLongestToken = 4096;

bool same_secret(const std::string& a, const std::string& b) {
  unsigned char x[32], y[32];
  crypto_generichash(x, sizeof x, reinterpret_cast<const unsigned char*>(a.data()), a.size(), nullptr, 0);
  crypto_generichash(y, sizeof y, reinterpret_cast<const unsigned char*>(b.data()), b.size(), nullptr, 0);
  return sodium_memcmp(x, y, sizeof x) == 0;
}

}  // namespace

void Access::check(const Request& request) const {
  check_host(request);
  if (request.method != "GET" && request.method != "HEAD") check_token(request);
}

// On loopback without a token, a page in this machine's browser is the stranger: it may resolve its own
// name to 127.0.0.1 (so the Host header must be ours) or post across origins.
void Access::check_host(const Request& request) const {
  if (!loopback_ || !token_.empty()) return;
  if (!is_loopback_host(request.get_header_value("Host")))
    throw HttpError{403, "forbidden", "this server answers to loopback names only (Host header)"};
  const std::string origin = request.get_header_value("Origin");
  if (!origin.empty() && origin != "http://" + request.get_header_value("Host"))
    throw HttpError{403, "forbidden", "requests from pages of other origins are refused"};
}

void Access::check_token(const Request& request) const {
  if (token_.empty()) return;
  const std::string given = request.get_header_value("Authorization");
  if (given.rfind("Bearer ", 0) == 0 && same_secret(given.substr(7), token_)) return;
  throw HttpError{401, "unauthorised",
                  given.empty() ? "a bearer token is needed (EVOGRASP_TOKEN_FILE or EVOGRASP_TOKEN)"
                                : "the bearer token is wrong"};
}

Result<std::string> load_token(const std::string& file) {
  const char* named = std::getenv("EVOGRASP_TOKEN_FILE");
  const std::string path = !file.empty() ? file : named != nullptr ? named : "";
  std::string token;
  if (!path.empty()) {
    std::ifstream in(path);
    token.resize(kLongestToken + 2);  // with "\r\n"
    in.read(token.data(), static_cast<std::streamsize>(token.size()));
    token.resize(static_cast<std::size_t>(in.gcount()));
    if (token.empty()) return fail(ErrorCode::kIo, path + ": cannot read a bearer token from it");
    token.resize(std::min(token.find('\n'), token.size()));
    while (!token.empty() && (token.back() == '\r' || token.back() == ' ')) token.pop_back();
  } else if (const char* text = std::getenv("EVOGRASP_TOKEN")) {
    token = text;
    if (token.empty()) return token;
  } else {
    return token;
  }
  const std::string place = path.empty() ? "EVOGRASP_TOKEN" : path;
  if (token.size() < kShortestToken || token.size() > kLongestToken)
    return fail(ErrorCode::kInvalid, place + ": a bearer token has " + std::to_string(kShortestToken) +
                                         " to " + std::to_string(kLongestToken) + " characters");
  if (has_control(token))  // would end the header that carries it
    return fail(ErrorCode::kInvalid, place + ": a bearer token has no control characters");
  return token;
}

}  // namespace evograsp::server

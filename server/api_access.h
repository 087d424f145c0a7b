// Who may ask the HTTP API what.
#pragma once

#include <httplib.h>

#include <string>

namespace evograsp::server {

// What ends a request with an error answer: {"error": {"code", "message"}}. Handlers throw it, since the
// library's handlers return nothing; it never leaves the API.
struct HttpError {
  int status;
  std::string code, message;
};

// Immutable and thread-safe.
class Access {
 public:
  Access(bool loopback, std::string token) : loopback_(loopback), token_(std::move(token)) {}
  // Throws HttpError: 403 for a stranger's page in a local browser, 401 for a change without the token.
  void check(const httplib::Request& request) const;

 private:
  void check_host(const httplib::Request& request) const;
  void check_token(const httplib::Request& request) const;
  const bool loopback_;
  const std::string token_;
};

}  // namespace evograsp::server

// What an evograsp server answers, taken as a stranger's word: status and body in, documents or errors out.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "cli/queries_source.h"

namespace evograsp::cli {

struct HttpAnswer {
  int status = 0;
  std::string body;
  std::string champion;  // the header X-Evograsp-Champion
};

// Puts one question: "GET", "POST" or "PUT", a path with its query, a JSON body or nothing. An error says why
// no answer came.
using AskServer =
    std::function<Result<HttpAnswer>(const char* method, const std::string& path, const std::string& body)>;

// The server at `url` as a source of answers. Errors begin with `url`: kUnavailable for what no evograsp
// server says, else the server's own reason with the code that its status comes to.
std::unique_ptr<Source> server_source(std::string url, AskServer ask);

}  // namespace evograsp::cli

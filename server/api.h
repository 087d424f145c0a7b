// The HTTP API of one run: /api/v1, /healthz, /readyz, /metrics, and the dashboard's files. docs/API.md is
// its manual.
//
// Reads come from the run's last snapshot and from a read-only connection to run.db: they never hold up
// evolution.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/strangers.h"
#include "proto/config.pb.h"
#include "server/run_control.h"

namespace evograsp::server {

// A file of the dashboard, kept in the program.
struct StaticFile {
  std::string path;          // "/", "/app.js"
  std::string content_type;  // "text/javascript"
  std::string bytes;
  bool gzipped = false;
};

struct ApiOptions {
  std::string listen = "127.0.0.1:8080";  // host:port or [v6]:port; port 0: any free one
  std::string token;                      // bearer token that changing state needs; empty: none
  bool insecure = false;                  // allow a non-loopback bind without a token
  std::filesystem::path run_dir;          // where run.db is
  std::vector<StaticFile> files;
  int threads = 16;
  std::shared_ptr<Strangers> strangers;  // told of those that are refused; absent: the server has its own
};

// The token a server or a client uses: the first line of `file` when given, else of the file that
// $EVOGRASP_TOKEN_FILE names, else $EVOGRASP_TOKEN, else empty. kInvalid for one under 16 or over 4096
// characters, or with control characters; kIo for an unreadable file.
Result<std::string> load_token(const std::string& file);

class ApiServer {
 public:
  // Binds and answers at once, on threads of its own. `run` must outlive the server. kUsage for a bad address
  // and for a non-loopback one without a token; kIo when the port is taken.
  static Result<std::unique_ptr<ApiServer>> create(ApiOptions options, RunControl& run);
  // Finishes the requests being answered.
  virtual ~ApiServer() = default;
  virtual int port() const = 0;
};

}  // namespace evograsp::server

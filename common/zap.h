// Who may connect to CURVE sockets: keys in files, an allow-list, and the handler that ZeroMQ asks (ZAP, RFC
// 27).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <zmq.hpp>

#include "common/result.h"
#include "common/socket.h"
#include "common/strangers.h"

namespace evograsp {

// A key file holds lines "public-key = KEY" and "secret-key = KEY" (Z85, 40 characters), "server-key = KEY"
// for a worker; # begins a comment. kInvalid when others may read a file with a secret in it: mode 0600 or
// less, or 0640 or less when it belongs to root (how Kubernetes and systemd hand out secrets).
Result<CurveKeys> load_keys(const std::filesystem::path& file);
// One public key a line, anything after it is a comment (the worker's name, say).
Result<std::set<std::string>> load_allow_list(const std::filesystem::path& file);
// Makes a new pair. Writes FILE with mode 0600; refuses to replace one. server_key: see load_keys; may be
// empty.
Result<CurveKeys> generate_keys(const std::filesystem::path& file, const std::string& server_key);

// Answers ZeroMQ's question about each handshake on sockets of `context`: CURVE with a key of the list comes
// in; without a list, on sockets without keys, everybody who speaks ZMTP 3. One a context, made before its
// sockets bind. Whom it turns away it tells `strangers`, or, without one, the log.
class Gatekeeper {
 public:
  static Result<std::unique_ptr<Gatekeeper>> create(zmq::context_t& context,
                                                    std::optional<std::set<std::string>> allowed,
                                                    std::shared_ptr<Strangers> strangers = nullptr);
  virtual ~Gatekeeper() = default;
  virtual std::uint64_t refused() const = 0;
};

}  // namespace evograsp

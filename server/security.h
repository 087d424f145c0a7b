// Who may talk to the master.
#pragma once

#include <memory>
#include <optional>
#include <zmq.hpp>

#include "common/result.h"
#include "common/socket.h"
#include "common/zap.h"
#include "proto/config.pb.h"
#include "server/dispatcher.h"

namespace evograsp::server {

class Security {
 public:
  // Reads the keys that net names, starts the gatekeeper for them, and refuses to expose what nothing
  // protects. Fills options.socket. Who is turned away is told options.strangers.
  Status open(zmq::context_t& context, const proto::NetConfig& net, DispatcherOptions& options);
  bool encrypted() const { return keys_.has_value(); }
  SocketOptions socket_options(const proto::NetConfig& net) const;

 private:
  std::optional<CurveKeys> keys_;
  std::unique_ptr<Gatekeeper> gatekeeper_;
};

}  // namespace evograsp::server

// Champions to robots as they are found: a PUB socket.
//
// Two frames a message: the topic "champion" and a serialised proto::Champion. Sent after the commit of a
// generation whose best is better than any before (validation_trials 0), and when the run has chosen
// (validation_trials > 0).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "common/connection_monitor.h"
#include "common/result.h"
#include "common/strangers.h"
#include "server/run_loop.h"
#include "server/security.h"

namespace evograsp::server {

// One thread at a time.
class Publisher {
 public:
  // Does nothing when net.publish is absent.
  Status open(zmq::context_t& context, const proto::NetConfig& net, const Security& security,
              std::shared_ptr<Strangers> strangers);
  void publish(const ResumePoint& run, const RunPosition& position);
  void publish(const proto::Champion& champion);
  // Tells of those that were refused since the last call. A few times a second.
  void look_at_door();
  const std::string& endpoint() const { return endpoint_; }  // what was bound; empty: nothing

 private:
  zmq::socket_t socket_;
  std::unique_ptr<ConnectionMonitor> monitor_;
  std::shared_ptr<Strangers> strangers_;
  std::string endpoint_;
  std::uint32_t sent_generation_ = 0;
  bool sent_ = false;
};

}  // namespace evograsp::server

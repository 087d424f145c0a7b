// Champions to robots as they are found: a PUB socket.
//
// Two frames a message: the topic "champion" and a serialised proto::Champion. Sent after the commit of a
// generation whose best is better than any before (validation_trials 0), and when the run has chosen
// (validation_trials > 0).
#pragma once

#include <optional>
#include <zmq.hpp>

#include "common/result.h"
#include "server/run_loop.h"
#include "server/security.h"

namespace evograsp::server {

// One thread at a time.
class Publisher {
 public:
  // Does nothing when net.publish is absent.
  Status open(zmq::context_t& context, const proto::NetConfig& net, const Security& security);
  void publish(const ResumePoint& run, const RunPosition& position);
  void publish(const proto::Champion& champion);

 private:
  zmq::socket_t socket_;
  std::uint32_t sent_generation_ = 0;
  bool sent_ = false;
};

}  // namespace evograsp::server

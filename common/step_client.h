// The three commands of a simulator slot somewhere else: `evograsp sim --connect`, panels, robots that stand
// in.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "common/result.h"
#include "common/socket.h"
#include "common/wire.h"
#include "proto/wire.pb.h"

namespace evograsp {

// Talks to a master, which passes each command to a slot of one of its workers. What comes back is bit for
// bit what the simulator library gives. Not thread-safe.
class StepClient {
 public:
  // kUnavailable when nobody answers within `seconds`, or with the master's reason when it refuses.
  static Result<StepClient> connect(const std::string& endpoint, const std::optional<CurveKeys>& keys,
                                    double seconds = 5);

  // What is simulated there.
  const proto::Experiment& experiment() const { return experiment_; }
  // One command: shuffle first, then get_info and get_quality about the scene it made (get_quality: about the
  // target of the last get_info). The master fills id and context. kInvalid with the slot's own words when
  // the command makes no sense; kUnavailable when there is no worker or no answer.
  Result<proto::StepReply> ask(proto::StepRequest request, double seconds = 10);
  // One of the experiment's assets by its id, packed as the master serves it: check it against the id before
  // use (assets::unpack_object, unpack_hand). kNotFound when the master does not have it.
  Result<std::string> asset(const std::string& id, double seconds = 10);

 private:
  StepClient() : context_(std::make_unique<zmq::context_t>(1)) {}
  struct Answer {
    proto::Envelope envelope;
    std::vector<zmq::message_t> attachments;
  };
  using Clock = std::chrono::steady_clock;
  static Clock::time_point after(double seconds);
  Result<Answer> next(Clock::time_point end);

  std::unique_ptr<zmq::context_t> context_;
  zmq::socket_t socket_;
  std::string endpoint_;
  SessionStamp stamp_;
  proto::Experiment experiment_;
  std::uint64_t last_id_ = 0;
};

}  // namespace evograsp

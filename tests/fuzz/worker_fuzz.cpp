// What a worker makes of its master's messages: every state of the session, up to tasks in its queue
// (task_fuzz goes on from there). The worker has no slots, so that nothing happens beside what the input
// says.
#include <spdlog/spdlog.h>

#include "assets/assets.h"
#include "common/socket.h"
#include "tests/fuzz/peer.h"
#include "worker/session.h"

namespace {

using namespace evograsp;

constexpr SessionStamp kStamp{7, 1};

// An experiment whose fingerprint is right is believed.
void mend(proto::Envelope& envelope) {
  if (!envelope.has_welcome()) return;
  proto::Experiment& experiment = *envelope.mutable_welcome()->mutable_experiment();
  experiment.set_fingerprint(assets::experiment_fingerprint(experiment));
}

class FuzzedWorker {
 public:
  FuzzedWorker() : router_(*make_router(fuzz::context(), {})) {
    options_.connect = *evograsp::bind(router_, fuzz::new_address());
    options_.slots = 0;
    options_.identity = "fuzzed";
    session_.emplace(fuzz::context(), options_, wakeup_, order_);
  }

  void run(fuzz::Pieces& pieces) {
    wakeup_->notify();  // no turn waits
    turn();
    for (int i = 0; i < 64 && !pieces.empty() && !session_->over() && !session_->lost(); ++i) {
      if (pieces.byte() % 16 == 15) order_ = pieces.byte() % 3;
      if (!peer_.empty()) say(fuzz::cut_message(pieces, kStamp, mend));
      turn();
    }
    order_ = worker::Session::kStop;
    wakeup_->notify();
    if (!session_->over() && !session_->lost()) turn();
  }

 private:
  void say(zmq::message_t frame) { send(router_, peer_, std::move(frame)); }

  void turn() {
    wakeup_->notify();
    const Status status = session_->turn();
    fuzz::require(status.has_value(), status ? "" : status.error().message.c_str());
    google::protobuf::Arena arena;
    Received received;
    while (receive(router_, true, arena, received)) {
      fuzz::require(received.fault.empty(), "a worker sends envelopes");
      peer_ = received.peer;
    }
  }

  zmq::socket_t router_;
  worker::WorkerOptions options_;
  const std::shared_ptr<Wakeup> wakeup_ = std::make_shared<Wakeup>();
  std::atomic<int> order_{worker::Session::kServe};
  std::optional<worker::Session> session_;
  std::string peer_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spdlog::set_level(spdlog::level::off);
  fuzz::Pieces pieces(data, size);
  FuzzedWorker().run(pieces);
  fuzz::settle();
  return 0;
}

// What a master makes of its workers' messages: three peers who join, work, lie, leave and come back as the
// input says. Whatever they send, every network is answered at most once, with all its measurements.
#include <spdlog/spdlog.h>

#include <array>

#include "common/socket.h"
#include "server/dispatch_loop.h"
#include "tests/fuzz/peer.h"

namespace {

using namespace evograsp;

constexpr SessionStamp kStamp{7, 1};
constexpr std::uint32_t kNetworks = 5, kTrials = 3;

class Sink : public server::WorkSink {
 public:
  void begin() { answered_.assign(kNetworks, false); }
  void evaluated(std::uint32_t index, std::vector<proto::Measurement> measurements) override {
    fuzz::require(measurements.size() == kTrials, "a network has all its measurements");
    answer(index);
  }
  void poisoned(const server::Poisoned& poisoned) override { answer(poisoned.network); }
  void retracted(const std::vector<std::uint32_t>& networks) override {
    for (const std::uint32_t index : networks) {
      fuzz::require(index < answered_.size() && answered_[index], "only what was said is taken back");
      answered_[index] = false;
    }
  }
  void finished() override {
    for (const bool answered : answered_) fuzz::require(answered, "work is finished when all is answered");
  }
  void notice(const std::string& text) override { require_clean(text); }
  void event(bool, const std::string&, const std::string& text) override { require_clean(text); }
  void worker(const server::PeerView& worker) override {
    require_clean(worker.identity + worker.host + worker.build);
  }
  void broken(const Error&) override { fuzz::require(false, "nothing a peer sends breaks the dispatcher"); }

 private:
  void answer(std::uint32_t index) {
    fuzz::require(index < answered_.size() && !answered_[index], "a network is answered once");
    answered_[index] = true;
  }
  static void require_clean(const std::string& text) {
    for (const char c : text) fuzz::require(static_cast<unsigned char>(c) >= 0x20, "logs are lines of text");
  }
  std::vector<bool> answered_;
};

server::DispatcherOptions options() {
  server::DispatcherOptions options;
  options.stamp = kStamp;
  options.heartbeat_seconds = 0;
  options.silence_seconds = 1e9;
  options.scheduler.poison_strikes = 2;
  options.audit_share = 0.5;
  options.experiment.set_fingerprint("f");
  options.assets = {{"a", "packed"}};
  return options;
}

// A worker as far as the master can tell.
class Peer {
 public:
  explicit Peer(const std::string& address) : socket_(*make_dealer(fuzz::context(), address, {})) {}
  void say(zmq::message_t frame) { send(socket_, {}, std::move(frame)); }
  void listen() {
    google::protobuf::Arena arena;
    Received received;
    while (receive(socket_, false, arena, received)) {
      fuzz::require(received.fault.empty(), "a master sends envelopes");
      if (!received.envelope->has_task()) continue;
      fuzz::require(memory_.complete(*received.envelope->mutable_task(), received.attachments).has_value(),
                    "a task comes with what its worker lacks");
      tasks_.push_back(received.envelope->task());
    }
  }
  // Names that a stranger cannot guess: versions, fingerprints, ids of the tasks it has been given.
  void mend(proto::Envelope& envelope) {
    if (envelope.has_hello()) {
      envelope.mutable_hello()->set_build(kVersion);
    } else if (envelope.has_ready()) {
      envelope.mutable_ready()->set_fingerprint("f");
    } else if (envelope.has_started() && !tasks_.empty()) {
      const proto::Task& task = tasks_[envelope.started().id() % tasks_.size()];
      envelope.mutable_started()->set_id(task.id());
      envelope.mutable_started()->set_attempt(task.attempt());
    } else if (envelope.has_result() && !tasks_.empty()) {
      const proto::Task& task = tasks_[envelope.result().id() % tasks_.size()];
      proto::TaskResult& result = *envelope.mutable_result();
      result.set_id(task.id());
      result.set_attempt(task.attempt());
      while (result.measurement_size() < task.network_size() * task.trial_size()) result.add_measurement();
    }
  }

 private:
  zmq::socket_t socket_;
  std::vector<proto::Task> tasks_;
  TaskMemory memory_;
};

class FuzzedMaster {
 public:
  FuzzedMaster()
      : router_(*make_router(fuzz::context(), {})), address_(*evograsp::bind(router_, fuzz::new_address())) {
    loop_.emplace(fuzz::context(), std::move(router_), options(), sink_);
    for (auto& peer : peers_) peer.emplace(address_);
  }

  void run(fuzz::Pieces& pieces) {
    begin();
    for (int i = 0; i < 128 && !pieces.empty(); ++i) {
      const std::uint8_t what = pieces.byte();
      if (what < 0xf0)
        say(*peers_[what % 3], pieces);
      else
        act(what, pieces);
      while (loop_->receive_some()) {
      }
      for (auto& peer : peers_) peer->listen();
    }
    loop_->view();
    loop_->dismiss("done");
  }

 private:
  void begin() {
    server::Work work;
    work.networks = kNetworks;
    work.trials.resize(kTrials);
    work.trial_set = 1;
    sink_.begin();
    loop_->begin(std::move(work));
    std::vector<server::NetworkFrame> networks;
    for (std::uint32_t i = 0; i < kNetworks; ++i) networks.push_back({100 + i, to_frame("network")});
    loop_->add(0, std::move(networks));
  }
  static void say(Peer& peer, fuzz::Pieces& pieces) {
    peer.say(fuzz::cut_message(pieces, kStamp, [&](proto::Envelope& e) { peer.mend(e); }));
  }
  void act(std::uint8_t what, fuzz::Pieces& pieces) {
    switch (what & 7) {
      case 0:
        return begin();
      case 1:
        return loop_->abandon();
      case 2:
        return loop_->set_paused(true);
      case 3:
        return loop_->set_paused(false);
      case 4:
        peers_[pieces.byte() % 3].emplace(address_);
        return;
      default:
        return loop_->tick();
    }
  }

  Sink sink_;
  zmq::socket_t router_;
  std::string address_;
  std::optional<server::DispatchLoop> loop_;
  std::array<std::optional<Peer>, 3> peers_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spdlog::set_level(spdlog::level::off);
  fuzz::Pieces pieces(data, size);
  FuzzedMaster().run(pieces);
  fuzz::settle();
  return 0;
}

// A peer that speaks the protocol frame by frame, for tests that want to say the wrong thing.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/connection_monitor.h"
#include "common/version.h"
#include "common/wire.h"
#include "server/dispatcher.h"

namespace evograsp::testing {

class RawPeer {
 public:
  RawPeer(zmq::context_t& context, const std::string& endpoint, const SocketOptions& options = {})
      : context_(context) {
    socket_ = std::move(*make_dealer(context, endpoint, options));
  }
  void send(const proto::Envelope& envelope) { evograsp::send(socket_, {}, envelope); }
  void send_bytes(const std::string& bytes) { socket_.send(zmq::buffer(bytes), zmq::send_flags::dontwait); }
  // Waits for room, so that everything really leaves; false when there is none for `seconds`.
  bool send_waiting(const std::string& bytes, double seconds = 1) {
    socket_.set(zmq::sockopt::sndtimeo, static_cast<int>(seconds * 1000));
    return socket_.send(zmq::buffer(bytes)).has_value();
  }
  // Takes what has come, unread.
  void ignore_answers() {
    zmq::message_t frame;
    while (socket_.recv(frame, zmq::recv_flags::dontwait)) {
    }
  }
  // From now on, whether the master ends the connection.
  void watch() { monitor_ = std::make_unique<ConnectionMonitor>(context_, socket_); }
  bool ended() {
    closed_ += monitor_->drain().closed.size();
    return closed_ > 0;
  }
  proto::Envelope hello(const std::string& identity, std::uint32_t pid = 1,
                        const std::string& host = "test") const {
    proto::Envelope envelope = make_envelope({});
    envelope.mutable_hello()->set_build(kVersion);
    envelope.mutable_hello()->set_host(host);
    envelope.mutable_hello()->set_pid(pid);
    envelope.mutable_hello()->set_slots(1);
    envelope.mutable_hello()->set_identity(identity);
    return envelope;
  }
  // The next message that is no heartbeat; nothing after `seconds`.
  std::optional<proto::Envelope> next(double seconds = 5) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      zmq::pollitem_t item{socket_.handle(), 0, ZMQ_POLLIN, 0};
      zmq::poll(&item, 1, std::chrono::milliseconds(10));
      google::protobuf::Arena arena;
      Received received;
      if (!receive(socket_, false, arena, received) || received.envelope == nullptr) continue;
      if (!received.envelope->has_heartbeat()) return *received.envelope;
    }
    return std::nullopt;
  }
  // Says hello and ready; the stamp is the master's from then on.
  bool join(const std::string& identity, const std::string& host = "test") {
    send(hello(identity, 1, host));
    const auto welcome = next();
    if (!welcome || !welcome->has_welcome()) return false;
    stamp_ = {welcome->run(), welcome->epoch()};
    proto::Envelope ready = make_envelope(stamp_);
    ready.mutable_ready()->set_fingerprint(welcome->welcome().experiment().fingerprint());
    send(ready);
    return true;
  }
  proto::Envelope result_of(const proto::Task& task) const {
    proto::Envelope envelope = make_envelope(stamp_);
    envelope.mutable_result()->set_id(task.id());
    envelope.mutable_result()->set_attempt(task.attempt());
    for (int i = 0; i < task.network_size() * static_cast<int>(task.trials()); ++i)
      envelope.mutable_result()->add_measurement();
    return envelope;
  }
  const SessionStamp& stamp() const { return stamp_; }

 private:
  zmq::context_t& context_;
  zmq::socket_t socket_;
  std::unique_ptr<ConnectionMonitor> monitor_;
  std::size_t closed_ = 0;
  SessionStamp stamp_;
};

// Counts what the dispatcher reports.
class CountingSink : public server::WorkSink {
  template <class F>
  auto locked(F f) const {
    const std::lock_guard lock(mutex_);
    return f();
  }

 public:
  void evaluated(std::uint32_t index, std::vector<proto::Measurement> measurements) override {
    const std::lock_guard lock(mutex_);
    ++evaluated_[index];
    for (const proto::Measurement& m : measurements) quality_[index] += m.quality();
  }
  void poisoned(const server::Poisoned& network) override {
    const std::lock_guard lock(mutex_);
    poisoned_.push_back(network.network);
  }
  void retracted(const std::vector<std::uint32_t>& networks) override {
    const std::lock_guard lock(mutex_);
    for (const std::uint32_t network : networks) {
      --evaluated_[network];
      quality_.erase(network);
    }
    retractions_ += networks.size();
  }
  void finished() override {
    const std::lock_guard lock(mutex_);
    ++finished_;
  }
  void notice(const std::string&) override {}
  void event(bool, const std::string& kind, const std::string& text) override {
    const std::lock_guard lock(mutex_);
    ++events_[kind];
    last_[kind] = text;
  }
  void worker(const server::PeerView&) override {}
  void broken(const Error& error) override { ADD_FAILURE() << error.message; }

  int finished_times() const {
    return locked([&] { return finished_; });
  }
  int events(const std::string& kind) const {
    return locked([&] { return events_.count(kind) ? events_.at(kind) : 0; });
  }
  // The last of its kind.
  std::string event_text(const std::string& kind) const {
    return locked([&] { return last_.count(kind) ? last_.at(kind) : std::string(); });
  }
  std::map<std::uint32_t, int> evaluations() const {
    return locked([&] { return evaluated_; });
  }
  std::size_t retractions() const {
    return locked([&] { return retractions_; });
  }
  bool all_zero_quality() const {
    return locked([&] {
      for (const auto& [network, quality] : quality_)
        if (quality != 0) return false;
      return true;
    });
  }
  std::vector<std::uint32_t> poison() const {
    return locked([&] { return poisoned_; });
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::uint32_t, int> evaluated_;
  std::vector<std::uint32_t> poisoned_;
  std::map<std::string, int> events_;
  std::map<std::string, std::string> last_;
  int finished_ = 0;
  std::map<std::uint32_t, double> quality_;  // summed, by network
  std::size_t retractions_ = 0;
};

// All of the work was evaluated, each network exactly once.
inline void expect_once(const CountingSink& sink, std::uint32_t networks) {
  const auto evaluations = sink.evaluations();
  EXPECT_EQ(evaluations.size(), networks);
  for (const auto& [index, times] : evaluations) EXPECT_EQ(times, 1) << "network " << index;
}

inline server::DispatcherOptions noop_options(std::size_t max_frame_bytes = 1 << 20) {
  server::DispatcherOptions options;
  options.endpoints = {"tcp://127.0.0.1:*"};
  options.socket.max_frame_bytes = static_cast<std::int64_t>(max_frame_bytes);
  options.stamp = {7, 1};
  options.heartbeat_seconds = 0.1;
  options.silence_seconds = 0.6;
  options.experiment.set_fingerprint("none");
  return options;
}

// `networks` x `trials` of no-op work, each network of which takes a slot so long.
inline void give_noop_work(server::Dispatcher& dispatcher, std::uint32_t networks, std::uint32_t trials,
                           double seconds, std::size_t bytes = 1000) {
  server::Work work;
  work.networks = networks;
  work.trials.resize(trials);
  work.noop_seconds = seconds;
  dispatcher.begin(std::move(work));
  std::vector<server::NetworkFrame> frames;
  for (std::uint32_t i = 0; i < networks; ++i) frames.push_back({i, to_frame(std::string(bytes, 'n'))});
  dispatcher.add(0, std::move(frames));
}

}  // namespace evograsp::testing

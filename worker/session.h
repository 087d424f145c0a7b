// The worker's side of the protocol: one connection at a time, on one thread.
//
//   greeting --Welcome--> loading --simulator stands--> serving --drain--> draining --> end
//      ^                     |                             |
//      +---- silence or a refusal that may pass: a new connection after a pause ----+
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "common/connection_monitor.h"
#include "common/socket.h"
#include "common/task_memory.h"
#include "common/watchdog.h"
#include "common/wire.h"
#include "worker/loader.h"
#include "worker/slots.h"
#include "worker/worker.h"

namespace evograsp::worker {

class Session {
 public:
  // `orders` is notified when drain or stop has been set.
  Session(zmq::context_t& context, const WorkerOptions& options, std::shared_ptr<Wakeup> wakeup,
          const std::atomic<int>& order);
  // A slot that hangs cannot be stopped: it is left behind, with what it needs, rather than waited for.
  ~Session();

  enum Order { kServe, kDrain, kStop };
  // Turns until the session is over; gives why.
  Status run();
  // Waits a moment for a message or an event and handles what is there. An error: no socket can be made.
  Status turn();
  bool over() const { return done_; }
  bool lost() const { return lost_; }  // the next turn connects anew, after a pause

 private:
  using Clock = std::chrono::steady_clock;
  enum class State { kGreeting, kLoading, kServing, kDraining };

  bool find_master();
  Status connect();
  void disconnect();
  void pause(double seconds);
  void wait();
  void read_all();
  void handle(Received& message);
  void on_welcome(const proto::Welcome& welcome, const SessionStamp& stamp);
  void on_refusal(const proto::Refusal& refusal);
  void on_asset(const proto::AssetReply& reply, const std::vector<zmq::message_t>& attachments);
  void on_cancel(const proto::Cancel& cancel);
  void on_drain(const proto::Drain& drain);
  void request_assets();
  void build_simulator();
  void take_simulator();
  void announce_ready(const std::string& fingerprint);
  void enqueue(Received& message);
  void send_events();
  void beat();
  void check_connection();
  void check_silence();
  void warn_of(FailedHandshake::Why why);
  void check_absence();
  void show_life();
  void obey();
  bool drained();
  void give_up(Error error);
  bool master_listens() const { return state_ == State::kServing || state_ == State::kDraining; }

  zmq::context_t& context_;
  const WorkerOptions& options_;
  const std::shared_ptr<Wakeup> wakeup_;
  const std::atomic<int>& order_;
  std::unique_ptr<SlotPool> slots_;
  Loader loader_;
  TaskMemory memory_;
  google::protobuf::Arena arena_;

  std::string endpoint_;  // of the master
  Watchdog watchdog_;
  Clock::time_point next_sign_{};

  zmq::socket_t socket_;
  std::unique_ptr<ConnectionMonitor> monitor_;  // a master that dies is missed at once, not after its silence
  State state_ = State::kGreeting;
  bool connected_ = false;
  bool lost_ = false;          // this connection has ended
  std::uint64_t session_ = 0;  // counts connections
  SessionStamp stamp_;
  double silence_seconds_ = 1.5;
  double heartbeat_seconds_ = 0.5;
  std::size_t largest_ = 0;  // message received, bytes
  static constexpr double kFirstPatience = 0.5;
  double patience_ = kFirstPatience;  // s, for a Welcome; grows while there is no master
  Clock::time_point heard_{}, looked_{}, next_beat_{}, drain_deadline_{};
  std::optional<FailedHandshake::Why> warned_of_;  // since a master was last heard
  Clock::time_point next_warning_{};
  Clock::time_point served_ = Clock::now();  // when a master was last heard
  std::string fingerprint_;                  // of the simulator that stands
  double trial_seconds_ = 0;                 // that a grasp takes it; 0: not tried
  std::string farewell_;
  int unfinished_ = 0;  // tasks taken and not answered
  std::vector<std::uint64_t> handed_back_;
  std::optional<Error> error_;  // why run() returns
  bool done_ = false;
  bool alone_said_ = false, sign_failed_ = false;  // warned already

  // Filled by the slot that builds a simulator.
  struct Built;
  std::shared_ptr<Built> built_;
};

}  // namespace evograsp::worker

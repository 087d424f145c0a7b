// The slots of a worker: N threads that evaluate tasks from one queue.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "common/mutex.h"
#include "common/socket.h"
#include "common/wire.h"
#include "proto/wire.pb.h"
#include "worker/evaluator.h"

namespace evograsp::worker {

// A task, a stepwise command or any other errand for a slot.
struct Job {
  SessionStamp stamp;
  std::uint64_t session = 0;  // of the connection it came by; what is left of an older one is dropped
  proto::Envelope envelope;   // holds a Task or a StepRequest
  std::vector<zmq::message_t> networks;
  std::function<void()> errand;  // when set, nothing else counts; keeps its errors to itself
};

// What the connection's thread has to send.
struct SlotEvent {
  std::uint64_t session = 0;
  std::uint64_t task = 0;  // 0: a stepwise reply
  zmq::message_t frame;    // envelope to send
};

// A task that is being evaluated.
struct StartedTask {
  std::uint64_t session = 0;
  std::uint64_t task = 0;
  std::uint32_t attempt = 0;
};

// Thread-safe.
class SlotPool {
 public:
  // `wakeup` is notified when events wait. Throws std::system_error, which says what to do, when there are
  // not enough threads.
  SlotPool(int slots, std::shared_ptr<Wakeup> wakeup);
  ~SlotPool();  // waits for what is running
  // Takes no more; false when something still runs after `seconds`.
  bool end(double seconds);

  // Jobs that start from now on use this simulator (null: none).
  void set_simulator(std::shared_ptr<SharedSimulator> shared);
  void push(Job job);
  // Drops those of the tasks that have not started; gives how many.
  int cancel(std::span<const std::uint64_t> tasks);
  // Takes back every task that has not started; gives their ids.
  std::vector<std::uint64_t> take_back();
  std::vector<SlotEvent> take_events();
  // Tasks that have run for `age` by now, and suspects at once; each is given once.
  std::vector<StartedTask> take_started(std::chrono::milliseconds age);
  int busy() const;
  int queued() const;

 private:
  struct Running {
    StartedTask what;
    std::chrono::steady_clock::time_point since;
    bool suspect = false;
    bool taken = false;  // by take_started()
  };

  void work(std::size_t slot);
  void run(Job& job, Evaluator& evaluator);
  void fail_job(const Job& job, const char* why);
  void post(SlotEvent event);

  const std::shared_ptr<Wakeup> wakeup_;

  mutable Mutex mutex_;
  std::condition_variable wanted_, idle_;
  std::deque<Job> queue_ GUARDED_BY(mutex_);
  std::vector<SlotEvent> events_ GUARDED_BY(mutex_);
  std::vector<std::optional<Running>> running_ GUARDED_BY(mutex_);  // by slot
  std::shared_ptr<SharedSimulator> shared_ GUARDED_BY(mutex_);
  std::uint64_t shared_version_ GUARDED_BY(mutex_) = 0;
  int busy_ GUARDED_BY(mutex_) = 0;
  bool stopping_ GUARDED_BY(mutex_) = false;

  std::vector<std::thread> threads_;
};

}  // namespace evograsp::worker

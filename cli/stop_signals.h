// Ctrl-C and SIGTERM as calls on a thread of their own: the first asks, the second insists.
#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace evograsp::cli {

// Blocks SIGINT, SIGTERM and SIGHUP in the calling thread and all threads it starts from then on: make one
// before any other thread. Handlers run on the watcher's thread.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals() { stop(); }

  // first: the run should commit and end. second: at once.
  void watch(std::function<void()> first, std::function<void()> second);
  // Ends the watcher. From then on a signal ends the process; call it in the thread that made this.
  void stop();
  bool seen() const { return count_.load() > 0; }

 private:
  std::atomic<int> count_{0};
  std::atomic<bool> done_{false};
  std::thread watcher_;
};

}  // namespace evograsp::cli

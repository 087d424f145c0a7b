// What Ctrl-C, SIGTERM and SIGHUP do to the command line.
#pragma once

#include <atomic>
#include <csignal>
#include <filesystem>
#include <functional>
#include <thread>

namespace evograsp::cli {

// For main(): from now on these signals end the program with exit code 130, whatever it is doing, without a
// word. Programs that it starts have their own ways.
void end_at_signals();

// Ends the program as end_at_signals() does, the file that is being written with it. Async-signal-safe.
[[noreturn]] void end_now();

// A file that is being written beside the one it will replace: end_now() takes it away, while this object
// lives. One at a time in a program; a second one is left to itself.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::filesystem::path& file);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

 private:
  bool named_ = false;
};

// The signals as calls on a thread of their own: the first asks, the second insists.
//
// Blocks them in the calling thread and all threads it starts from then on: make one before any other thread.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals() { stop(); }

  // first: the run should commit and end. The second signal is end_now().
  void watch(std::function<void()> first);
  // Ends the watcher. From then on a signal ends the program; call it in the thread that made this.
  void stop();

 private:
  const sigset_t set_;
  std::atomic<bool> done_{false};
  std::thread watcher_;
};

}  // namespace evograsp::cli

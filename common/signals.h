// SIGINT, SIGTERM and SIGHUP as calls on a thread of their own.
#pragma once

#include <csignal>
#include <functional>
#include <thread>

#include "common/mutex.h"

namespace evograsp {

// SIGINT and SIGTERM, and SIGHUP unless whoever started the program wants it ignored (nohup): a blocked
// signal would come through all the same.
sigset_t stop_signals();

// Make one before any other thread: it blocks the signals in the calling thread and in all that follow from
// it.
class SignalWatch {
 public:
  SignalWatch();
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  // Until start(), any signal ends the process at once with exit code 130: while files are read, say.
  void end_at_signal();
  // first: called at the first signal, on the watcher's thread. A second signal ends the process at once with
  // exit code 130; what comes within 0.3 s of the first is a copy of it (batch systems signal every process
  // of a job, and so does the job's script).
  void start(std::function<void()> first);
  // From its return on, `first` is neither running nor called: call it before what `first` uses goes away. A
  // second signal still ends the process.
  void forget();

 private:
  void watch();

  int signals_ = -1, end_ = -1;
  Mutex mutex_;
  bool end_at_once_ GUARDED_BY(mutex_) = false;
  std::function<void()> first_ GUARDED_BY(mutex_);
  std::thread thread_;
};

// Forgets at its end: stands after whatever `first` uses, so that it goes before.
class SignalScope {
 public:
  explicit SignalScope(SignalWatch& watch) : watch_(watch) {}
  ~SignalScope() { watch_.forget(); }
  SignalScope(const SignalScope&) = delete;
  SignalScope& operator=(const SignalScope&) = delete;

 private:
  SignalWatch& watch_;
};

// Tells systemd (Type=notify) the state of the service, e.g. "READY=1" or "STOPPING=1"; does nothing
// elsewhere.
void notify_service_manager(const char* state);

}  // namespace evograsp

// SIGINT, SIGTERM and SIGHUP as calls on a thread of their own.
#pragma once

#include <functional>
#include <thread>

namespace evograsp {

// Make one before any other thread: it blocks the signals in the calling thread and in all that follow from
// it.
class SignalWatch {
 public:
  SignalWatch();
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  // first: called at the first signal, on the watcher's thread. A second signal ends the process at once with
  // exit code 130; what comes within 0.3 s of the first is a copy of it (batch systems signal every process
  // of a job, and so does the job's script).
  void start(std::function<void()> first);

 private:
  int signals_ = -1, end_ = -1;
  std::thread thread_;
};

// Tells systemd (Type=notify) the state of the service, e.g. "READY=1" or "STOPPING=1"; does nothing
// elsewhere.
void notify_service_manager(const char* state);

}  // namespace evograsp

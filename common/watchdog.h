// Life signs for a service manager that watches (systemd: Type=notify with WatchdogSec).
#pragma once

#include <chrono>
#include <cstdint>

namespace evograsp {

// The manager restarts a process that has not said WATCHDOG=1 for WatchdogSec. Call beat() from the loop
// whose progress is the process's life: a thread of its own would go on beating while that loop hangs. One
// thread.
class Watchdog {
 public:
  using Clock = std::chrono::steady_clock;
  // Reads $WATCHDOG_USEC and $WATCHDOG_PID (sd_watchdog_enabled(3)); without them beat() does nothing.
  Watchdog();

  bool watched() const { return interval_.count() > 0; }
  // Says that all is well, at most four times in the manager's patience, however often it is called.
  void beat();

 private:
  std::chrono::microseconds interval_{0};
  Clock::time_point next_{};
};

}  // namespace evograsp

#include "cli/stop_signals.h"

#include <csignal>
#include <ctime>

namespace evograsp::cli {
namespace {

sigset_t stop_set() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
  return set;
}

}  // namespace

StopSignals::StopSignals() {
  const sigset_t set = stop_set();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

void StopSignals::stop() {
  done_ = true;
  if (watcher_.joinable()) watcher_.join();
  const sigset_t set = stop_set();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

void StopSignals::watch(std::function<void()> first, std::function<void()> second) {
  watcher_ = std::thread([this, first = std::move(first), second = std::move(second)] {
    const sigset_t set = stop_set();
    const timespec tick{0, 50'000'000};
    while (!done_) {
      if (sigtimedwait(&set, nullptr, &tick) < 0) continue;
      (count_.fetch_add(1) == 0 ? first : second)();
    }
  });
}

}  // namespace evograsp::cli

#include "common/watchdog.h"

#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <cstring>

#include "common/signals.h"

namespace evograsp {

namespace {

constexpr int kBeatsInPatience = 4;

// A variable that is a whole number above zero, else 0.
std::int64_t positive(const char* variable) {
  const char* text = std::getenv(variable);
  if (text == nullptr) return 0;
  std::int64_t value = 0;
  const char* end = text + std::strlen(text);
  const auto [at, problem] = std::from_chars(text, end, value);
  return problem == std::errc() && at == end && value > 0 ? value : 0;
}

}  // namespace

Watchdog::Watchdog() {
  // The manager's word to another process of the service is not for this one.
  if (std::getenv("WATCHDOG_PID") != nullptr && positive("WATCHDOG_PID") != getpid()) return;
  interval_ = std::chrono::microseconds(positive("WATCHDOG_USEC") / kBeatsInPatience);
}

void Watchdog::beat() {
  if (!watched()) return;
  const auto now = Clock::now();
  if (now < next_) return;
  next_ = now + interval_;
  notify_service_manager("WATCHDOG=1");
}

}  // namespace evograsp

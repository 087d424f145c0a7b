// Logging: for people on a terminal, or one JSON object a line for machines. Always on stderr: stdout is for
// answers.
#pragma once

#include <spdlog/spdlog.h>

#include <string>

namespace evograsp {

struct LogOptions {
  bool json = false;  // {"time":...,"level":...,"message":...}
  spdlog::level::level_enum level = spdlog::level::info;
};

// Installs the process's default logger. Call once, before other threads log.
void set_up_logging(const LogOptions& options);

// "debug", "info", "warn", "error", "off"; false when the name is none of these.
bool set_log_level(const std::string& name);
std::string log_level();

// Lets through `burst` lines at once and then one every `seconds`; counts what it held back. For complaints
// that a stranger could cause a million of. Not thread-safe.
class LogLimiter {
 public:
  LogLimiter(int burst, double seconds) : burst_(burst), seconds_(seconds), tokens_(burst) {}
  bool allow(double now_seconds);
  // As good as new.
  bool rested(double now_seconds) const { return tokens_ + (now_seconds - last_) / seconds_ >= burst_; }
  std::uint64_t held_back() const { return held_back_; }

 private:
  double burst_, seconds_;
  double tokens_;
  double last_ = 0;
  std::uint64_t held_back_ = 0;
};

}  // namespace evograsp

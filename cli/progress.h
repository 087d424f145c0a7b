// A run's progress on standard error: one line that redraws itself on a terminal, now and then a line
// elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <string>

#include "server/server.h"

namespace evograsp::cli {

enum class ProgressStyle { kSilent, kLines, kBar };

// kBar on a terminal, else kLines.
ProgressStyle progress_style(std::FILE* out);

// One thread at a time.
class Progress {
 public:
  Progress(ProgressStyle style, std::uint32_t generations, std::FILE* out = stderr);
  void show(const server::GenerationReport& report);
  // Leaves the line as it is and goes to the next.
  void finish();

  // The line for a report: what show() writes, without the bar's colours and cursor movements; `mean`: with
  // the population's mean fitness.
  static std::string line(const server::GenerationReport& report, std::uint32_t generations,
                          double trials_a_second, double seconds_left, int bar_width, bool mean = true);

 private:
  using Clock = std::chrono::steady_clock;
  struct Mark {
    double seconds;  // of the run, when the generation ended: reports come several at once
    std::uint64_t trials;
    std::uint32_t generation;
  };

  const ProgressStyle style_;
  const std::uint32_t generations_;
  std::FILE* const out_;
  std::deque<Mark> recent_;  // rate and time left come from the last generations
  Clock::time_point last_line_;
  bool open_line_ = false;
};

// "42 s", "3:07 min", "2:05 h".
std::string duration(double seconds);
// "1,234,567".
std::string with_commas(std::uint64_t number);

}  // namespace evograsp::cli

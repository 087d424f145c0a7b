// How far a study is, on standard error: which run of how many, how it goes, and the time left.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "cli/progress.h"
#include "cli/run_folder.h"

namespace evograsp::cli::study {

struct PlannedWork {
  std::string id;
  std::string kind;  // runs of one kind differ in their seed alone: they take about as long
  std::uint32_t generations = 0;
  double trials = 0;
};

// One thread at a time. On a terminal one line redraws itself; elsewhere each finished run is a line.
class StudyProgress {
 public:
  explicit StudyProgress(ProgressStyle style, std::FILE* out = stderr) : style_(style), out_(out) {}

  void begin(std::vector<PlannedWork> work);
  void start(std::size_t index);
  void generation(const server::GenerationReport& report);
  void measuring(const std::string& what);
  void done(std::size_t index, const RunFolder& run);
  void finish();  // leaves the line

  // Of everything not done, s: like took like, else by trials; NaN before anything took time.
  double seconds_left() const;

 private:
  using Clock = std::chrono::steady_clock;
  void show(const std::string& what);

  const ProgressStyle style_;
  std::FILE* const out_;
  std::vector<PlannedWork> work_;
  std::vector<bool> done_;
  struct Spent {
    double seconds = 0, trials = 0;
    int runs = 0;
  };
  std::map<std::string, Spent> kinds_;  // of runs that were done now, not before
  Spent all_;
  std::size_t current_ = 0;
  bool worked_ = false;  // on the current one: it was not there already
  double part_ = 0;      // of the current one
  Clock::time_point started_;
  Clock::time_point shown_{};
  std::size_t count_ = 0;
  bool open_line_ = false;
};

}  // namespace evograsp::cli::study

// What a finished run is measured for: its champion's tests, and the best of each generation looked at again.
// Kept in the run's folder, so that a study that is interrupted does nothing twice.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/run_folder.h"
#include "common/result.h"
#include "proto/study.pb.h"

namespace evograsp::cli::study {

struct TestedObject {
  std::string object;  // built-in name, or the file's name without folder and extension
  int n = 0, successes = 0, lifts = 0, unseen = 0;
  bool lifted = false;  // the lift test was made
  double extent_m = 0;  // smallest_width
  std::string refused;  // not empty: cannot be used, for this reason
};

// Of the best network of a generation.
struct CurvePoint {
  std::uint32_t generation = 0;
  std::optional<double> f1, f2, f3, f4;  // means over the trials it was bred by
  int fresh_n = 0, fresh_successes = 0;
  double fresh_fitness = 0;  // mean over the fresh placements
};

struct Measured {
  std::vector<TestedObject> tests;
  std::vector<CurvePoint> curve;
};

struct MeasureOptions {
  proto::Study study;
  std::vector<std::string> objects;  // of the test; empty: those the run was trained on
  double scale = 0, mass = 0;        // of mesh files among them; 0: file units are metres, mass by density
  int threads = 0;                   // 0: one a core; the answer does not depend on it
  const std::atomic<bool>* stop = nullptr;  // when it turns true, no more is done
  std::function<void(const std::string&)> tell = [](const std::string&) {};  // what is being done
};

// Of a finished run. What is in the folder's measured.json already is taken from there, when it was measured
// the same way on the same champion. kUnavailable: stopped; what was done is kept.
Result<Measured> measure(const RunFolder& run, const MeasureOptions& options);

}  // namespace evograsp::cli::study

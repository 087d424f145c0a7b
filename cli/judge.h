// How often a network grasps an object in placements that it has never met.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "common/network.h"
#include "common/result.h"
#include "sim/simulator.h"

namespace evograsp::cli {

struct JudgeOptions {
  int placements = 100;
  std::uint64_t seed = 1;  // placement i is that of (seed, Purpose::kTest, 0, i), whatever the object
  bool bounding_box = true;
  bool lift = true;                         // also the lift test: slower
  int threads = 0;                          // 0: one a core; the answer does not depend on it
  const std::atomic<bool>* stop = nullptr;  // when it turns true: kUnavailable, soon
};

struct Interval {
  double low = 0, high = 0;
};

struct Judgement {
  int n = 0;
  int successes = 0;  // stable grasps (score::success)
  int lifts = 0;      // grasps that held when lifted and shaken (sim/lift.h), in force closure or not
  int unseen = 0;     // placements in which the camera saw nothing of the object; counted as failures

  double success() const { return n > 0 ? static_cast<double>(successes) / n : 0; }
  double lift_success() const { return n > 0 ? static_cast<double>(lifts) / n : 0; }
};

// Of the simulator's object `target`. Thread-safe. An error when the scene cannot be laid out, or when the
// network's inputs and outputs are not the simulator's.
Result<Judgement> judge(const Network& network, const sim::Simulator& simulator, int target,
                        const JudgeOptions& options);

// 95 % confidence interval of a rate (Wilson 1927, equation 4 with z = 1.96); [0, 1] without trials.
Interval wilson(int successes, int n);

}  // namespace evograsp::cli

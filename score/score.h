// Measurements to fitness (Algorithm 1 of the thesis, 4.2.2.1) and to success.
#pragma once

#include <span>

#include "common/result.h"
#include "proto/config.pb.h"
#include "proto/wire.pb.h"

namespace evograsp::score {

struct Terms {
  double f1 = 0, f2 = 0, f3 = 0, f4 = 0;
  double hold = 0;   // in [0, 1]: how near the grasp is to the target's centre (fitness.hold_range)
  double total = 0;  // the enabled ones, less what fitness.hold_weight takes
};

// Immutable and thread-safe.
class Scorer {
 public:
  static Result<Scorer> create(const proto::FitnessConfig& config);
  // Finite whatever the measurement says; zero for one that cannot have been measured (NaN, infinities,
  // negative distances).
  Terms trial(const proto::Measurement& m) const;
  // Mean of the trials in the order given; 0 for none.
  double evaluation(std::span<const proto::Measurement> trials) const;

 private:
  double gamma_, f1_cap_, beta_, alpha_, k_, lambda_, epsilon_, omega_, w_, theta_min_, theta_max_,
      near_target_, hold_weight_, hold_range_;
  bool f_enabled_[5];
  bool normalised_, gate_;
};

// A stable grasp of the target: force closure in the kinematic trial.
bool success(const proto::Measurement& m);
// Survived the lift test; false for what was not lifted.
bool held(const proto::Measurement& m);

}  // namespace evograsp::score

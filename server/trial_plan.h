// Which trials a generation consists of: common random numbers, the same for each of its networks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/config.pb.h"
#include "proto/wire.pb.h"

namespace evograsp::server {

struct TrialPlan {
  std::uint64_t set = 0;  // names the list
  std::vector<proto::TrialKey> trials;
  std::string stage;  // of optional ones: Evaluation.stage
};

// config.trials.scenes placements; in each, every object that stands there is target in turn (or one drawn by
// the seed), with config.trials.clicks clicks each. New ones each generation.
TrialPlan plan_generation(const proto::Config& config, std::uint32_t generation);

// Optional trials of a generation: as many again, on other placements, for those that race on into round 0,
// 1, ...
TrialPlan plan_optional(const proto::Config& config, std::uint32_t generation, std::uint32_t round);

// config.champion.validation_trials trials, each on a placement of its own that no generation has seen;
// targets take turns among the objects that stand there.
TrialPlan plan_validation(const proto::Config& config);

// Lift tests on placements of their own: of the champion's finalists (config.lift.finalist_trials), and of
// the best of a generation (config.lift.trials).
TrialPlan plan_final_lifts(const proto::Config& config);
TrialPlan plan_lifts(const proto::Config& config, std::uint32_t generation);

}  // namespace evograsp::server

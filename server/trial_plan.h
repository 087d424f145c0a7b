// Which trials a generation consists of: common random numbers, the same for each of its networks.
#pragma once

#include <cstdint>
#include <vector>

#include "proto/config.pb.h"
#include "proto/wire.pb.h"

namespace evograsp::server {

struct TrialPlan {
  std::uint64_t set = 0;  // names the list
  std::vector<proto::TrialKey> trials;
};

// config.trials.scenes placements; in each, every object that stands there is target in turn (or one drawn by
// the seed), with config.trials.clicks clicks each. New ones each generation.
TrialPlan plan_generation(const proto::Config& config, std::uint32_t generation);

// config.champion.validation_trials trials, each on a placement of its own that no generation has seen;
// targets take turns among the objects that stand there.
TrialPlan plan_validation(const proto::Config& config);

}  // namespace evograsp::server

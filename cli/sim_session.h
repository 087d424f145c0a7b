// A simulator to talk to in the three commands, here or elsewhere: what sim, render and test drive.
#pragma once

#include <cstdint>
#include <memory>

#include "assets/assets.h"
#include "common/result.h"
#include "sim/simulator.h"

namespace evograsp::cli {

// One conversation. shuffle() comes first; the other two speak of the scene it made. Not thread-safe.
class SimSession {
 public:
  virtual ~SimSession() = default;

  // Experiment and bundles, defaults written out.
  virtual const assets::ResolvedExperiment& experiment() const = 0;

  virtual Result<sim::Placements> shuffle(std::uint64_t seed) = 0;
  virtual Result<sim::Info> get_info(int target, int click, bool bounding_box) = 0;
  // `tool`: commanded tool pose X_WT, world.
  virtual Result<sim::GraspReport> get_quality(int target, const Pose& tool) = 0;
};

// In this process.
Result<std::unique_ptr<SimSession>> local_session(assets::ResolvedExperiment experiment);

}  // namespace evograsp::cli

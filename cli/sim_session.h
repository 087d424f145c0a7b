// A simulator to talk to in the three commands, here or elsewhere: what sim, render and test drive.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "assets/assets.h"
#include "common/result.h"
#include "common/socket.h"
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

// In this process. Poses are given and taken as they cross the wire, as quaternions: the same conversation
// with a slot elsewhere gives the same bits.
Result<std::unique_ptr<SimSession>> local_session(assets::ResolvedExperiment experiment);
// On a slot of the master at `endpoint`; its experiment is what counts. kUnavailable when nobody answers or
// the master has no worker.
Result<std::unique_ptr<SimSession>> remote_session(const std::string& endpoint,
                                                   const std::optional<CurveKeys>& keys);

}  // namespace evograsp::cli

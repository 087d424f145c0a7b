// Friction of every pair of a hand's link and an object.
#pragma once

#include <cstdint>
#include <vector>

#include "common/result.h"
#include "proto/wire.pb.h"
#include "sim/hand.h"

namespace evograsp::sim {

// Immutable and thread-safe.
class Friction {
 public:
  // SceneConfig.friction by the two materials in either order (the last entry of a pair wins), else
  // default_friction.
  Friction() = default;
  Friction(const proto::SceneConfig& scene, const std::vector<proto::ObjectBundle>& objects,
           const HandModel& hand);

  // With friction_jitter, the placement's seed scales each object's friction by a factor uniform in
  // [1 - jitter, 1 + jitter).
  double mu(int object, int link, std::uint64_t placement_seed) const;

 private:
  int links_ = 0;
  double jitter_ = 0;
  std::vector<double> mu_;  // [object x link]
};

}  // namespace evograsp::sim

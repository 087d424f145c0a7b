// One number for everything that trials measure, so that machines, compilers and orders can be compared.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/lift.h"
#include "tests/sim/trials.h"

namespace evograsp::sim::testing {

inline std::uint64_t fold(std::uint64_t h, double v) {
  return mix64(h ^ std::bit_cast<std::uint64_t>(v));
}

inline std::uint64_t fold(std::uint64_t h, const Vec3& v) {
  return fold(fold(fold(h, v.x()), v.y()), v.z());
}

inline std::uint64_t digest_of(const Measurement& m) {
  std::uint64_t h = mix64(static_cast<std::uint64_t>(m.outcome) + 1);
  h = fold(h, m.quality);
  h = fold(h, m.contacts);
  h = fold(h, m.obstructions);
  h = fold(fold(fold(h, m.p), m.s), m.o);
  return fold(fold(fold(h, m.nearest_object), m.target_distance), m.theta);
}

// The trial's own number: shuffle, pose, attempt; with `details` contacts and joints as well, with `look` the
// network's inputs as well.
inline std::uint64_t digest_trial(const Simulator& sim, std::uint64_t index, Workspace& workspace,
                                  bool look = false) {
  const Trial trial = random_trial(sim, index);
  GraspReport report;
  std::uint64_t h =
      digest_of(sim.get_quality(trial.placements, trial.target, trial.tool, workspace, &report));
  for (const Contact& c : report.contacts) h = fold(fold(fold(h, c.point), c.normal), c.gap);
  for (const double q : report.joints) h = fold(h, q);
  if (look) {
    const auto info = sim.get_info(trial.placements, trial.target, 0, true);
    if (!info) return mix64(h);
    for (const float d : info->depth) h = fold(h, d);
    h = fold(fold(fold(h, info->point), info->anchor), info->click_a + 2 * info->click_b);
  }
  return h;
}

inline std::uint64_t digest_of(const LiftReport& lift) {
  std::uint64_t h = mix64(lift.held ? 1 : 2);
  h = fold(fold(fold(h, lift.slip), lift.max_displacement), lift.turn);
  h = fold(fold(h, lift.lost_at), lift.time);
  for (const double q : lift.joints) h = fold(h, q);
  return h;
}

// The lift test of the first of `trials` whose grasp closes; nothing when none does.
inline std::optional<std::uint64_t> digest_lift(const Simulator& sim, std::uint64_t trials,
                                                Workspace& workspace) {
  for (std::uint64_t i = 0; i < trials; ++i) {
    const Trial trial = random_trial(sim, i);
    GraspReport attempt;
    if (sim.get_quality(trial.placements, trial.target, trial.tool, workspace, &attempt).quality <= 0)
      continue;
    const auto lift = lift_test(sim, trial.placements, trial.target, attempt);
    return lift ? digest_of(*lift) : mix64(0);
  }
  return {};
}

}  // namespace evograsp::sim::testing

// Random trials on the built-in objects and hands: what the tests, the digest program and the benchmarks
// share.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "assets/assets.h"
#include "common/det_math.h"
#include "common/random.h"
#include "sim/simulator.h"

namespace evograsp::sim::testing {

// `config` holds what differs from the defaults.
inline std::shared_ptr<const Simulator> make_simulator(const std::vector<std::string>& objects,
                                                       const std::string& hand = "meka_h2",
                                                       proto::Config config = {}) {
  for (const std::string& name : objects) config.mutable_scene()->add_object(name);
  config.mutable_grasp()->set_hand(hand);
  auto resolved = assets::resolve_experiment(config, EVOGRASP_SOURCE_DIR);
  if (!resolved) {
    std::fprintf(stderr, "cannot make an experiment: %s\n", resolved.error().message.c_str());
    std::abort();
  }
  auto sim = Simulator::create(resolved->experiment, resolved->objects, resolved->hand);
  if (!sim) {
    std::fprintf(stderr, "cannot make a simulator: %s\n", sim.error().message.c_str());
    std::abort();
  }
  return *sim;
}

struct Trial {
  Placements placements;
  int target = 0;
  Pose tool;
};

// A pose near the target: the tool point within `spread` m of its centre of mass, the approach axis tilted up
// to 86 degrees from straight down, any yaw and roll.
inline Pose random_tool_pose(Random& random, const Vec3& target, double spread) {
  const double yaw = random.uniform(-det::kPi, det::kPi);
  const double tilt = random.uniform(0, 1.5);
  const double roll = random.uniform(-det::kPi, det::kPi);
  const double dx = random.uniform(-spread, spread);
  const double dy = random.uniform(-spread, spread);
  const double dz = random.uniform(-spread, spread);
  Pose tool;
  tool.rotation = rotation_about(Vec3::UnitZ(), yaw) * rotation_about(Vec3::UnitY(), det::kPi - tilt) *
                  rotation_about(Vec3::UnitZ(), roll);
  tool.position = target + Vec3(dx, dy, dz);
  return tool;
}

inline Trial random_trial(const Simulator& sim, std::uint64_t index, double spread = 0.03) {
  Random random(7, Purpose::kTestHarness, 0, index);
  Trial trial;
  auto placed = sim.shuffle(index);
  if (!placed) std::abort();
  trial.placements = std::move(*placed);
  trial.target = static_cast<int>(random.below(static_cast<std::uint32_t>(sim.object_count())));
  const auto t = static_cast<std::size_t>(trial.target);
  const Vec3 centre = trial.placements.pose[t] * from_proto(sim.object(trial.target).centre_of_mass());
  trial.tool = random_tool_pose(random, centre, spread);
  return trial;
}

}  // namespace evograsp::sim::testing

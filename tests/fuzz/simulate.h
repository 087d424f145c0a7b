// A simulator of hostile parts: what has been accepted must be able to run a trial.
#pragma once

#include <cmath>

#include "assets/assets.h"
#include "sim/simulator.h"
#include "tests/fuzz/fuzz.h"

namespace evograsp::fuzz {

inline proto::Config small_config() {
  proto::Config config;
  config.mutable_scene()->add_object("cube");
  config.mutable_grasp()->set_hand("parallel_jaw");
  config.mutable_camera()->set_columns(4);
  config.mutable_camera()->set_rows(3);
  return config;
}

inline const assets::ResolvedExperiment& small_experiment() {
  static const assets::ResolvedExperiment experiment = *assets::resolve_experiment(small_config(), {});
  return experiment;
}

inline void run_trial(const sim::Simulator& simulator) {
  const auto placements = simulator.shuffle(1);
  if (!placements) return;
  const auto info = simulator.get_info(*placements, 0, 0, true);
  if (info)
    for (const float d : info->depth) require(d >= 0 && d <= 1, "depths are within 0 and 1");
  const auto workspace = simulator.make_workspace();
  for (const double height : {0.3, 0.1, 0.03}) {
    Pose tool = placements->pose[0];
    tool.position.z() = height;
    tool.rotation.col(1) *= -1;
    tool.rotation.col(2) *= -1;
    const sim::Measurement m = simulator.get_quality(*placements, 0, tool, *workspace);
    require(std::isfinite(m.quality) && m.quality >= 0 && m.contacts >= 0, "a trial gives a measurement");
  }
}

}  // namespace evograsp::fuzz

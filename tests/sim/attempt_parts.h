// The parts of an attempt, assembled without the simulator, so that tests can look between the steps.
#pragma once

#include <memory>

#include "sim/approach.h"
#include "sim/closing.h"
#include "tests/sim/trials.h"

namespace evograsp::sim::testing {

struct AttemptParts {
  HandModel hand;
  World world;
  PosedWorld posed;
  HandState state;
  ApproachScratch scratch;
  Closing closing;
  double tolerance = 2e-4;

  explicit AttemptParts(const Simulator& sim, int object_count)
      : hand(*HandModel::create(sim.hand(), sim.experiment().grasp().contact_tolerance())),
        world(make_world(sim, object_count)),
        state(hand),
        closing(hand, world.part_count()),
        tolerance(sim.experiment().grasp().contact_tolerance()) {}
  explicit AttemptParts(const Simulator& sim) : AttemptParts(sim, sim.object_count()) {}

  static World make_world(const Simulator& sim, int object_count) {
    std::vector<proto::ObjectBundle> objects;
    for (int i = 0; i < object_count; ++i) objects.push_back(sim.object(i));
    return *World::create(sim.experiment().scene(), objects);
  }

  Vec3 direction(const Pose& tool) const { return tool.rotation * hand.approach_axis(); }
  Pose start(const Pose& tool) const {
    return {tool.rotation, tool * Vec3(-hand.tool_point()) - hand.standoff() * direction(tool)};
  }

  // Places, opens and approaches; false when the start is blocked.
  bool approach_only(const Trial& trial) {
    world.place(trial.placements, posed);
    Pose palm = start(trial.tool);
    state.open(hand, palm);
    const Vec3 d = direction(trial.tool);
    const ApproachResult way = approach(hand, state, posed, d, hand.standoff(), tolerance, scratch);
    palm.position += way.travelled * d;
    state.open(hand, palm);
    return !way.blocked;
  }

  // The smallest distance of any part from any obstacle.
  double clearance() const {
    double least = 1;
    for (std::size_t p = 0; p < hand.parts().size(); ++p)
      for (const Obstacle& o : posed.obstacle)
        least = std::min(least, distance(hand.parts()[p].shape, state.part[p], o).distance);
    return least;
  }
  // The same between parts of the hand: not those of neighbouring links, of one motor, or together from the
  // start.
  double self_clearance() const {
    double least = 1;
    for (std::size_t p = 0; p < hand.parts().size(); ++p)
      for (std::size_t q = 0; q < p; ++q)
        if (apart(hand.parts()[p], hand.parts()[q]))
          least = std::min(
              least,
              distance(hand.parts()[p].shape, state.part[p], hand.parts()[q].shape, state.part[q]).distance);
    return least;
  }

 private:
  int parent(int link) const {
    return link == 0 ? -1 : hand.joints()[static_cast<std::size_t>(link - 1)].parent_link;
  }
  bool apart(const HandPart& a, const HandPart& b) const {
    if (a.link == b.link || parent(a.link) == b.link || parent(b.link) == a.link) return false;
    for (const HandMotor& motor : hand.motors())
      if ((hand.ancestors(a.link) & motor.joints) && (hand.ancestors(b.link) & motor.joints)) return false;
    return distance(a.shape, a.preset_pose, b.shape, b.preset_pose).distance > 1e-3;
  }
};

}  // namespace evograsp::sim::testing

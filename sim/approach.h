// The approach: the open hand moves in a straight line until it touches something.
#pragma once

#include <vector>

#include "sim/hand_state.h"
#include "sim/world.h"

namespace evograsp::sim {

struct ApproachResult {
  double travelled = 0;  // m along the direction
  bool blocked = false;  // the start already touches
};

// Scratch memory; allocates only while it grows.
struct ApproachScratch {
  struct Candidate {
    double enter;  // m: the boxes of the pair meet no earlier
    int part, obstacle;
  };
  std::vector<Candidate> candidate;
  std::vector<Aabb> part_box;
};

// How far the hand, posed in `state`, can move along `direction` (unit, world) up to `length` m until any
// part is within `tolerance` of the table or of an object. Conservative advancement along the line (van den
// Bergen, "Ray casting against general convex objects", 2004): the distance of convex shapes is convex along
// a line, so that steps of distance / closing speed come down on the first touch from above and nothing thin
// is skipped. The hand rests with a gap between 0.9 of the tolerance and the tolerance.
ApproachResult approach(const HandModel& hand, const HandState& state, const PosedWorld& world,
                        const Vec3& direction, double length, double tolerance, ApproachScratch& scratch);

}  // namespace evograsp::sim

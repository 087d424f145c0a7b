// Where a hand is: joint values and the poses of its links and parts. Scratch memory of one slot.
#pragma once

#include <vector>

#include "sim/hand.h"

namespace evograsp::sim {

struct HandState {
  std::vector<double> value;  // one a joint, rad or m
  std::vector<Pose> link;     // X_WL
  std::vector<Pose> part;     // X_WP

  explicit HandState(const HandModel& hand)
      : value(hand.preset()), link(static_cast<std::size_t>(hand.link_count())), part(hand.parts().size()) {}

  // All joints at their preset, the palm at X_WH.
  void open(const HandModel& hand, const Pose& X_WH) {
    value = hand.preset();
    pose(hand, X_WH);
  }
  void pose(const HandModel& hand, const Pose& X_WH) {
    hand.forward(value, X_WH, link);
    for (std::size_t p = 0; p < part.size(); ++p)
      part[p] = link[static_cast<std::size_t>(hand.parts()[p].link)] * hand.parts()[p].pose;
  }
};

}  // namespace evograsp::sim

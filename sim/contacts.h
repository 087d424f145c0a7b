// What the closed hand touches.
#pragma once

#include <vector>

#include "sim/hand_state.h"
#include "sim/patch.h"
#include "sim/simulator.h"
#include "sim/world.h"

namespace evograsp::sim {

// Contacts of the hand's links with the target, in canonical order (link, part, coordinates): of each pair of
// a link's part and a part of the target that are within `margin`, the patch of contact_patch(). mu is left
// to the caller (0).
//
// A pair counts only where it is the nearest one: when the point of the link lies nearer to another part of
// the target (or the point of the target to another part of the link), the pair looks at a seam between
// convex parts from aside, where the real surface has no edge, and its normal means nothing.
//
// Returns the obstructions: how many links are within `margin` of anything else, the table included.
int collect_contacts(const HandModel& hand, const HandState& state, const PosedWorld& world, int target,
                     double margin, std::vector<Contact>& contacts);

}  // namespace evograsp::sim

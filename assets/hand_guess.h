// What a URDF leaves open about a hand, guessed so that a bare URDF can be looked at. A hand file says it
// right.
#pragma once

#include <urdf_model/model.h>

#include <string>
#include <vector>

#include "assets/hand_tree.h"
#include "common/result.h"
#include "proto/hand.pb.h"

namespace evograsp::assets {

// The link from which the most moving chains branch (the first from the root of equals). An error for a robot
// without two such chains anywhere: an arm.
Result<std::string> guess_palm(const urdf::ModelInterface& model);

// Fills the axes (fingers: mean direction of the chains; approach: where the tips go when they curl), the
// tool point (between the tips half closed) and the thumb (the chain whose tip travels most against the
// others).
void guess_frame(const HandTree& tree, proto::HandFile& file, std::vector<std::string>& warnings);

// Motors: one a leader with its <mimic> followers where the URDF has any; else one a chain from the palm, of
// the joints parallel to its last one, closing towards the farther limit.
void guess_motors(const HandTree& tree, proto::HandFile& file, std::vector<std::string>& warnings);

}  // namespace evograsp::assets

// A URDF link's collision geometry as convex parts.
#pragma once

#include <urdf_model/link.h>

#include <string>
#include <vector>

#include "assets/hand_tree.h"
#include "common/result.h"
#include "proto/bundle.pb.h"

namespace evograsp::assets {

inline constexpr std::size_t kMaxPartsPerLink = 32;

// The link at `pose`. A cylinder with equal balls centred on its two ends becomes one capsule (URDF has none
// of its own). Without <collision> the <visual> is taken; a mesh becomes its convex hull. Missing mesh files
// and links that end up without any shape are warnings.
Result<std::vector<proto::ConvexPart>> link_parts(const urdf::Link& link, const Pose& pose,
                                                  const GeometrySource& source,
                                                  std::vector<std::string>& warnings);

}  // namespace evograsp::assets

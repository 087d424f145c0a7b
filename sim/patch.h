// From one closest pair to the patch of contact around it.
#pragma once

#include <array>

#include "sim/gjk.h"
#include "sim/shape.h"

namespace evograsp::sim {

inline constexpr int kMaxPatch = 4;

struct PatchPoint {
  Vec3 point;  // on b's surface, world
  double gap;  // m, along the normal
};

struct Patch {
  std::array<PatchPoint, kMaxPatch> point;
  int count = 0;
};

// Where a and b are within `margin` along the normal of their closest pair: the witness alone where round or
// pointed things meet, the two ends of the line where a rod lies along a rod or a face, up to four corners
// where two faces meet. One contact a pair would make a flat fingertip pivot like a needle.
//
// The features (corner, edge, face) that lie within the margin along the normal are clipped against each
// other in the tangent plane (Sutherland and Hodgman, "Reentrant polygon clipping", CACM 1974); of more than
// four corners the four that span the most area are kept.
Patch contact_patch(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const Separation& closest, double margin);

}  // namespace evograsp::sim

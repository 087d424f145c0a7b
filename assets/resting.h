// The ways an object can come to rest on a table.
#pragma once

#include <vector>

#include "common/pose.h"

namespace evograsp::assets {

struct RestingFace {
  Vec3 down;     // unit, object frame: the direction that points to the table
  double share;  // of all directions that roll to this face without momentum, 0 to 1
};

// The stable faces of the hull of `points` with the centre of mass there, at most `max_faces`: first the one
// it was modelled on, -z down, if that is stable, then the others, likeliest first.
//
// An object that touches the table with a face over which its centre of mass does not stand rolls over the
// edge that the centre is farthest beyond, and so on; the share of a face is the solid angle, seen from the
// centre, of the faces that end there (Goldberg et al., "Part pose statistics: estimators and experiments",
// IEEE T-RA 15(5), 1999). Ends less than 15 degrees apart are one face of a curved or rough side. Left out:
// faces on which the centre stands less than 1 mm inside what touches the table to within 1 mm, and shares
// below 3 % but for -z. When that leaves none, the likeliest. {}: fewer than 4 points, points in a plane, or
// a centre outside of the hull. Deterministic; equal shares stand in the hull's order.
std::vector<RestingFace> resting_faces(const std::vector<Vec3>& points, const Vec3& centre_of_mass,
                                       std::size_t max_faces = 6);

}  // namespace evograsp::assets

// Convex hulls of point sets, and smaller ones that stand for them.
#pragma once

#include <vector>

#include "assets/solid.h"
#include "common/pose.h"
#include "proto/bundle.pb.h"

namespace evograsp::assets {

struct ConvexHull {
  struct Face {
    Vec3 normal;            // outward unit; zero for a sliver, whose direction means nothing
    double offset;          // largest normal . p of the hull: a supporting plane
    std::vector<int> loop;  // into vertices
  };
  std::vector<Vec3> vertices;  // some of the input points, exactly
  std::vector<Face> faces;
  Solid solid;  // volume 0 when the points lie in a plane
  double area = 0;
  double width = 0;  // least extent across any face's normal: how thin it is; 0 when all faces are slivers

  // How far p lies outside (positive) or inside the nearest face's plane. Means nothing when width is 0.
  double distance(const Vec3& p) const;
};

// By Bullet's integer algorithm (robust for any input): no point lies farther outside than 2e-4 of the
// diagonal of their box. O(n log n).
ConvexHull convex_hull(const std::vector<Vec3>& points);

// At most max_vertices of the hull's vertices, chosen greedily: always the one farthest outside the hull of
// those chosen before, until none lies farther out than `tolerance`.
std::vector<Vec3> reduced_hull(const ConvexHull& hull, std::size_t max_vertices, double tolerance);

// The hull of `points` (at most max_vertices of them) as a part whose outer surface is the hull's: the core
// is the hull with its faces moved in by the rounding, which shrinks for thin hulls (down to 0.05 mm, below
// which the part grows by that much instead). Corners of more than three faces cannot always follow all of
// them: needles and slivers may stand out, by four times the rounding at most.
proto::ConvexPart part_from_points(const std::vector<Vec3>& points, std::size_t max_vertices,
                                   double rounding);

}  // namespace evograsp::assets

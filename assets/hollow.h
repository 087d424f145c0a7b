// Where a mesh is not: sample points that a convex part should not swallow.
#pragma once

#include <vector>

#include "assets/hull.h"
#include "assets/mesh.h"

namespace evograsp::assets {

// Points of a grid of at most max_points cells over the mesh's box that lie inside `hull` (the mesh's own),
// outside the mesh, and farther than `depth` from its surface. Outside is judged by the generalised winding
// number below one half (Jacobson, Kavan and Sorkine-Hornung, "Robust inside-outside segmentation using
// generalized winding numbers", SIGGRAPH 2013, eq. 5), which also serves torn meshes. O(points x triangles).
std::vector<Vec3> hollow_points(const Mesh& mesh, const ConvexHull& hull, double depth,
                                std::size_t max_points);

// Distance of p from a triangle (Ericson, "Real-Time Collision Detection", 2005, 5.1.5).
double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace evograsp::assets

// Smooth surfaces as triangles: bodies of revolution and bent tubes.
#pragma once

#include <span>
#include <vector>

#include "common/pose.h"
#include "proto/bundle.pb.h"

namespace evograsp::assets {

// A point of a profile: distance from the z axis and height.
struct ProfilePoint {
  double radius, z;
};

// Turns the profile about the z axis. Closed and outward when the profile starts and ends on the axis (radius
// 0) and runs anticlockwise seen with radius to the right and z up.
void add_lathe(std::span<const ProfilePoint> profile, int sides, proto::TriangleMesh& mesh);
// A closed tube of the given radius along a path in the xz plane.
void add_tube(std::span<const Vec3> path, double radius, int sides, proto::TriangleMesh& mesh);

}  // namespace evograsp::assets

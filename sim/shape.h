// Convex shapes as the simulator computes with them: a convex core swept by a ball.
//
// Every collision part of an object and of a hand is one Shape. Shapes are immutable and safe to share. All
// functions are pure; none allocates but the construction from a bundle.
#pragma once

#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"

namespace evograsp::sim {

// The core that is swept. The order is part of the code's dispatch, not of any stored format.
enum class Core : unsigned char {
  kPoint,    // a ball
  kSegment,  // a capsule, along z
  kBox,
  kDisc,  // a cylinder (rounded edges), along z
  kHull,  // the convex hull of a few vertices
};
inline constexpr int kCores = 5;
inline constexpr int kMaxHullVertices = 4096;

struct Aabb {
  Vec3 lo = Vec3::Zero(), hi = Vec3::Zero();

  bool overlaps(const Aabb& b, double margin) const {
    return lo.x() <= b.hi.x() + margin && b.lo.x() <= hi.x() + margin && lo.y() <= b.hi.y() + margin &&
           b.lo.y() <= hi.y() + margin && lo.z() <= b.hi.z() + margin && b.lo.z() <= hi.z() + margin;
  }
  // Squared distance of a point; 0 inside.
  double squared_distance(const Vec3& p) const;
};

struct Shape {
  Core core = Core::kPoint;
  double sweep = 0;             // m, radius of the ball
  Vec3 half = Vec3::Zero();     // box: half sizes; segment: (0, 0, h); disc: (r, r, h); of the core
  std::vector<double> x, y, z;  // hull: vertices
  Vec3 centre = Vec3::Zero();   // of a ball that holds the whole shape
  double radius = 0;            // its radius, sweep included

  // From a bundle's part: the outer sizes less the rounding, checked: finite, positive, below 100 m.
  static Result<Shape> from_proto(const proto::ConvexPart& part);
  static Shape ball(double radius_m);
  static Shape capsule(double radius_m, double half_length_m);
  static Shape box(const Vec3& outer_half_m, double rounding_m);
  static Shape cylinder(double radius_m, double half_length_m, double rounding_m);
  static Shape hull(const std::vector<Vec3>& core_vertices, double rounding_m);

  // A point of the core that is extreme along direction (any length), in the shape's frame.
  Vec3 support(const Vec3& direction) const;
};

// Makes `out` the same shape, `factor` times as large about its frame's origin. Takes no memory once `out`
// has held as many vertices.
void set_scaled(const Shape& shape, double factor, Shape& out);

// The smallest axis-aligned box around a posed shape, sweep included; exact.
Aabb bounds(const Shape& shape, const Pose& pose);

}  // namespace evograsp::sim

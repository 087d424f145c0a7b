// Convex parts: makers and the few questions asked of them. Sizes are outer sizes, rounding included.
#pragma once

#include <optional>
#include <vector>

#include "common/pose.h"
#include "proto/bundle.pb.h"

namespace evograsp::assets {

inline constexpr double kRounding = 0.0005;  // edge radius of built-in shapes, m

// The rounding shrinks with parts too small for it, so that a core remains.
proto::ConvexPart box_part(const Pose& pose, const Vec3& half, double rounding = kRounding);
proto::ConvexPart ball_part(const Vec3& centre, double radius);
proto::ConvexPart cylinder_part(const Pose& pose, double radius, double half_length,
                                double rounding = kRounding);
// From a to b (cap centres).
proto::ConvexPart capsule_part(const Vec3& a, const Vec3& b, double radius);
// Core vertices in the body frame; the part's own frame is put at their mean.
proto::ConvexPart hull_part(const std::vector<Vec3>& core, double rounding);

// Largest d . p over the surface; d unit, body frame.
double support(const proto::ConvexPart& part, const Vec3& d);
// Largest distance of the surface from a point.
double farthest(const proto::ConvexPart& part, const Vec3& from);
// Largest distance of the surface from the axis through the origin along the unit vector d; for round parts
// seen from the side up to 0.2 % above it.
double axis_reach(const proto::ConvexPart& part, const Vec3& d);

// The rotation of least angle that takes unit vector a to unit vector b.
Mat3 rotation_between(const Vec3& a, const Vec3& b);
// v scaled to length 1; nothing when it is not finite or shorter than 1e-9. Long vectors do not overflow.
std::optional<Vec3> direction_of(const Vec3& v);
// Any unit vector perpendicular to the unit vector d.
Vec3 any_perpendicular(const Vec3& d);

}  // namespace evograsp::assets

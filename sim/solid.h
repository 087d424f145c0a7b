// A convex part in the form that rays and projections need: exact intersections in double precision.
#pragma once

#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "sim/camera.h"

namespace evograsp::sim {

// A ball around a part or a body, for quick rejection.
struct BoundingBall {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
  // False only if the ray's line misses the ball.
  bool touches(const Ray& ray) const;
};

// Sizes are outer sizes; the rounding of a box's or rod's edges (half a millimetre) is left to the collision
// code, that of a hull moves its faces outwards. Immutable and thread-safe; a value.
class Solid {
 public:
  enum class Kind { kBox, kBall, kCylinder, kCapsule, kHull };

  // Errors: sizes that are not finite and positive, hulls without volume or with more than 4096 vertices.
  static Result<Solid> create(const proto::ConvexPart& part);

  Kind kind() const { return kind_; }
  const Pose& pose() const { return X_BP_; }          // part in the body frame
  const BoundingBall& ball() const { return ball_; }  // body frame
  const Vec3& size() const { return size_; }  // box: half sizes; ball, rods: (radius, radius, half length)
  const std::vector<Vec3>& vertices() const { return vertices_; }  // hull: core vertices, part frame
  double rounding() const { return rounding_; }

  // The first t in (t_min, t_max) at which the ray (body frame) enters the part. Rays that start inside go on
  // to what lies beyond: they do not hit this part.
  bool enter(const Ray& ray_B, double t_min, double t_max, double* t) const;
  // Outward unit normal at a point on the surface (body frame). Edges of boxes and rods are shaded round over
  // `bevel_m` when it is positive.
  Vec3 normal(const Vec3& p_B, double bevel_m = 0) const;
  // The point farthest along a direction (body frame).
  Vec3 support(const Vec3& direction_B) const;

 private:
  struct Plane {
    Vec3 normal;
    double offset;  // normal . p <= offset inside
  };
  friend Status build_faces(Solid& solid, const proto::ConvexPart::Hull& hull);
  bool enter_box(const Ray& ray, double* t) const;
  bool enter_rod(const Ray& ray, double* t) const;
  bool enter_hull(const Ray& ray, double* t) const;

  Kind kind_ = Kind::kBall;
  Pose X_BP_;
  Vec3 size_ = Vec3::Zero();
  double rounding_ = 0;
  std::vector<Vec3> vertices_;
  std::vector<Plane> planes_;
  BoundingBall ball_;
};

}  // namespace evograsp::sim

#include "sim/shape.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "sim/support.h"

namespace evograsp::sim {
namespace {

constexpr double kLargest = 100;  // m: anything larger is a mistake in units

bool is_size(double v) {
  return v > 0 && v < kLargest;
}

Shape swept(Core core, const Vec3& half, double sweep) {
  Shape s;
  s.core = core;
  s.half = half;
  s.sweep = sweep;
  s.radius = half.norm() + sweep;
  return s;
}

tl::unexpected<Error> bad(const char* what) {
  return fail(ErrorCode::kInvalid, std::string("convex part: ") + what);
}

Result<Shape> hull_from_proto(const proto::ConvexPart::Hull& hull, double rounding) {
  if (hull.xyz_size() % 3 != 0) return bad("hull coordinates do not come in threes");
  const int n = hull.xyz_size() / 3;
  if (n < 1 || n > kMaxHullVertices) return bad("a hull needs 1 to 4096 vertices");
  std::vector<Vec3> vertices;
  vertices.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    const Vec3 v(hull.xyz(3 * i), hull.xyz(3 * i + 1), hull.xyz(3 * i + 2));
    if (!is_finite(v) || !(v.norm() < kLargest)) return bad("hull vertex is not finite or beyond 100 m");
    vertices.push_back(v);
  }
  return Shape::hull(vertices, rounding);
}

}  // namespace

double Aabb::squared_distance(const Vec3& p) const {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double gap = std::max({0.0, lo[i] - p[i], p[i] - hi[i]});
    sum += gap * gap;
  }
  return sum;
}

Shape Shape::ball(double r) {
  return swept(Core::kPoint, Vec3::Zero(), r);
}

Shape Shape::capsule(double r, double half_length) {
  return swept(Core::kSegment, {0, 0, half_length}, r);
}

Shape Shape::box(const Vec3& outer, double rounding) {
  return swept(Core::kBox, outer - Vec3::Constant(rounding), rounding);
}

Shape Shape::cylinder(double r, double half_length, double rounding) {
  Shape s = swept(Core::kDisc, {r - rounding, r - rounding, half_length - rounding}, rounding);
  s.radius = std::sqrt(s.half.x() * s.half.x() + s.half.z() * s.half.z()) + rounding;
  return s;
}

Shape Shape::hull(const std::vector<Vec3>& vertices, double rounding) {
  Shape s;
  s.core = Core::kHull;
  s.sweep = rounding;
  Vec3 lo = vertices.front(), hi = lo;
  for (const Vec3& v : vertices) {
    s.x.push_back(v.x());
    s.y.push_back(v.y());
    s.z.push_back(v.z());
    lo = lo.cwiseMin(v);
    hi = hi.cwiseMax(v);
  }
  s.centre = 0.5 * (lo + hi);
  s.half = 0.5 * (hi - lo);
  double farthest = 0;
  for (const Vec3& v : vertices) farthest = std::max(farthest, (v - s.centre).norm());
  s.radius = farthest + rounding;
  return s;
}

Result<Shape> Shape::from_proto(const proto::ConvexPart& part) {
  const double rounding = part.rounding();
  if (!(rounding >= 0 && rounding < kLargest)) return bad("rounding is negative or not finite");
  switch (part.shape_case()) {
    case proto::ConvexPart::kBox: {
      const Vec3 half(part.box().hx(), part.box().hy(), part.box().hz());
      if (!is_size(half.x()) || !is_size(half.y()) || !is_size(half.z())) return bad("box size out of range");
      if (half.minCoeff() < rounding) return bad("box is thinner than its rounding");
      return box(half, rounding);
    }
    case proto::ConvexPart::kBall:
      if (!is_size(part.ball().radius())) return bad("ball radius out of range");
      return ball(part.ball().radius());
    case proto::ConvexPart::kCylinder:
      if (!is_size(part.cylinder().radius()) || !is_size(part.cylinder().half_length()))
        return bad("cylinder size out of range");
      if (std::min(part.cylinder().radius(), part.cylinder().half_length()) < rounding)
        return bad("cylinder is thinner than its rounding");
      return cylinder(part.cylinder().radius(), part.cylinder().half_length(), rounding);
    case proto::ConvexPart::kCapsule:
      if (!is_size(part.capsule().radius())) return bad("capsule radius out of range");
      if (!(part.capsule().half_length() >= 0 && part.capsule().half_length() < kLargest))
        return bad("capsule length out of range");
      return capsule(part.capsule().radius(), part.capsule().half_length());
    case proto::ConvexPart::kHull:
      return hull_from_proto(part.hull(), rounding);
    case proto::ConvexPart::SHAPE_NOT_SET:
      break;
  }
  return bad("has no shape");
}

Vec3 Shape::support(const Vec3& d) const {
  switch (core) {
    case Core::kPoint:
      return core_support<Core::kPoint>(*this, d);
    case Core::kSegment:
      return core_support<Core::kSegment>(*this, d);
    case Core::kBox:
      return core_support<Core::kBox>(*this, d);
    case Core::kDisc:
      return core_support<Core::kDisc>(*this, d);
    case Core::kHull:
      break;
  }
  return core_support<Core::kHull>(*this, d);
}

namespace {

// Half the width of the core along world axis i, about the image of its centre; hulls are not symmetric.
double half_width(const Shape& s, const Mat3& r, int i) {
  switch (s.core) {
    case Core::kPoint:
      return 0;
    case Core::kSegment:
      return std::fabs(r(i, 2)) * s.half.z();
    case Core::kDisc:
      return std::sqrt(std::max(0.0, r(i, 0) * r(i, 0) + r(i, 1) * r(i, 1))) * s.half.x() +
             std::fabs(r(i, 2)) * s.half.z();
    default:
      return std::fabs(r(i, 0)) * s.half.x() + std::fabs(r(i, 1)) * s.half.y() +
             std::fabs(r(i, 2)) * s.half.z();
  }
}

}  // namespace

Aabb bounds(const Shape& s, const Pose& pose) {
  Aabb box;
  for (int i = 0; i < 3; ++i) {
    if (s.core == Core::kHull) {
      const Vec3 axis = pose.rotation.row(i).transpose();
      box.hi[i] = axis.dot(s.support(axis)) + pose.position[i] + s.sweep;
      box.lo[i] = axis.dot(s.support(-axis)) + pose.position[i] - s.sweep;
    } else {
      const double w = half_width(s, pose.rotation, i) + s.sweep;
      box.lo[i] = pose.position[i] - w;
      box.hi[i] = pose.position[i] + w;
    }
  }
  return box;
}

void set_scaled(const Shape& shape, double factor, Shape& out) {
  const auto copy = [&](const std::vector<double>& from, std::vector<double>& to) {
    to.assign(from.begin(), from.end());
    for (double& v : to) v *= factor;
  };
  out.core = shape.core;
  out.sweep = factor * shape.sweep;
  out.half = factor * shape.half;
  copy(shape.x, out.x), copy(shape.y, out.y), copy(shape.z, out.z);
  out.centre = factor * shape.centre;
  out.radius = factor * shape.radius;
}

}  // namespace evograsp::sim

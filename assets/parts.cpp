#include "assets/parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/det_math.h"

namespace evograsp::assets {
namespace {

// A part seen as points and circles, each swept by a ball: enough for every question here.
struct Outline {
  std::vector<Vec3> points;
  struct Circle {
    Vec3 centre, normal;
    double radius;
  };
  std::vector<Circle> circles;
  double sweep = 0;
};

Outline outline_of(const proto::ConvexPart& part) {
  const Pose pose = from_proto(part.pose());
  const double r = part.rounding();
  Outline out;
  out.sweep = r;
  if (part.has_box()) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 h(part.box().hx() - r, part.box().hy() - r, part.box().hz() - r);
      out.points.push_back(pose * Vec3((corner & 1) ? h.x() : -h.x(), (corner & 2) ? h.y() : -h.y(),
                                       (corner & 4) ? h.z() : -h.z()));
    }
  } else if (part.has_ball()) {
    out.points.push_back(pose.position);
    out.sweep = part.ball().radius();
  } else if (part.has_capsule()) {
    const double h = part.capsule().half_length();
    out.points = {pose * Vec3(0, 0, -h), pose * Vec3(0, 0, h)};
    out.sweep = part.capsule().radius();
  } else if (part.has_cylinder()) {
    const double h = part.cylinder().half_length() - r;
    for (const double z : {-h, h}) {
      out.circles.push_back({pose * Vec3(0, 0, z), pose.rotation.col(2), part.cylinder().radius() - r});
    }
  } else {
    const auto& xyz = part.hull().xyz();
    for (int i = 0; i + 2 < xyz.size(); i += 3)
      out.points.push_back(pose * Vec3(xyz[i], xyz[i + 1], xyz[i + 2]));
  }
  return out;
}

Vec3 across(const Vec3& p, const Vec3& axis) {
  return p - axis.dot(p) * axis;
}

proto::ConvexPart posed(const Pose& pose, double rounding) {
  proto::ConvexPart part;
  *part.mutable_pose() = to_proto(pose);
  part.set_rounding(rounding);
  return part;
}

}  // namespace

proto::ConvexPart box_part(const Pose& pose, const Vec3& half, double rounding) {
  proto::ConvexPart part = posed(pose, std::min(rounding, half.minCoeff() / 2));
  part.mutable_box()->set_hx(half.x());
  part.mutable_box()->set_hy(half.y());
  part.mutable_box()->set_hz(half.z());
  return part;
}

proto::ConvexPart ball_part(const Vec3& centre, double radius) {
  proto::ConvexPart part = posed({Mat3::Identity(), centre}, 0);
  part.mutable_ball()->set_radius(radius);
  return part;
}

proto::ConvexPart cylinder_part(const Pose& pose, double radius, double half_length, double rounding) {
  proto::ConvexPart part = posed(pose, std::min(rounding, std::min(radius, half_length) / 2));
  part.mutable_cylinder()->set_radius(radius);
  part.mutable_cylinder()->set_half_length(half_length);
  return part;
}

proto::ConvexPart capsule_part(const Vec3& a, const Vec3& b, double radius) {
  const double length = (b - a).norm();
  const Mat3 rotation =
      length > 0 ? rotation_between(Vec3::UnitZ(), (b - a) / length) : Mat3(Mat3::Identity());
  proto::ConvexPart part = posed({rotation, (a + b) / 2}, 0);
  part.mutable_capsule()->set_radius(radius);
  part.mutable_capsule()->set_half_length(length / 2);
  return part;
}

proto::ConvexPart hull_part(const std::vector<Vec3>& core, double rounding) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : core) mean += p;
  mean /= static_cast<double>(std::max<std::size_t>(core.size(), 1));
  proto::ConvexPart part = posed({Mat3::Identity(), mean}, rounding);
  for (const Vec3& p : core) {
    for (int k = 0; k < 3; ++k) part.mutable_hull()->add_xyz(p[k] - mean[k]);
  }
  return part;
}

double support(const proto::ConvexPart& part, const Vec3& d) {
  const Outline outline = outline_of(part);
  double best = -HUGE_VAL;
  for (const Vec3& p : outline.points) best = std::max(best, d.dot(p));
  for (const auto& c : outline.circles) {
    const double along = d.dot(c.normal);
    best = std::max(best, d.dot(c.centre) + c.radius * std::sqrt(std::max(0.0, 1 - along * along)));
  }
  return best + outline.sweep;
}

double farthest(const proto::ConvexPart& part, const Vec3& from) {
  const Outline outline = outline_of(part);
  double best = 0;
  for (const Vec3& p : outline.points) best = std::max(best, (p - from).norm());
  for (const auto& c : outline.circles) {
    const Vec3 q = c.centre - from;
    const double axial = q.dot(c.normal), radial = across(q, c.normal).norm() + c.radius;
    best = std::max(best, std::sqrt(axial * axial + radial * radial));
  }
  return best + outline.sweep;
}

double axis_reach(const proto::ConvexPart& part, const Vec3& d) {
  constexpr int kSides = 64;
  const Outline outline = outline_of(part);
  double best = 0;
  for (const Vec3& p : outline.points) best = std::max(best, across(p, d).norm());
  for (const auto& c : outline.circles) {
    if (std::fabs(c.normal.dot(d)) > 1 - 1e-12) {
      best = std::max(best, across(c.centre, d).norm() + c.radius);
      continue;
    }
    const Vec3 u = any_perpendicular(c.normal), v = c.normal.cross(u);
    const double radius = c.radius / det::cos(det::kPi / kSides);  // circumscribed: never too small
    for (int i = 0; i < kSides; ++i) {
      const double a = 2 * det::kPi * i / kSides;
      best = std::max(best, across(c.centre + radius * (det::cos(a) * u + det::sin(a) * v), d).norm());
    }
  }
  return best + outline.sweep;
}

std::optional<Vec3> direction_of(const Vec3& v) {
  constexpr double kLeast = 1e-9, kSquareable = 1e100;
  if (!is_finite(v)) return std::nullopt;
  const double most = v.cwiseAbs().maxCoeff();
  const Vec3 scaled = most > kSquareable ? Vec3(v / most) : v;
  const double length = scaled.norm();
  if (!(length > kLeast)) return std::nullopt;
  return Vec3(scaled / length);
}

Vec3 any_perpendicular(const Vec3& d) {
  const Vec3 other = std::fabs(d.x()) < 0.6 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 p = d.cross(other);
  return p / p.norm();
}

Mat3 rotation_between(const Vec3& a, const Vec3& b) {
  const double c = a.dot(b);
  if (c < -1 + 1e-12) {  // half a turn about any perpendicular axis
    const Vec3 u = any_perpendicular(a);
    return 2 * u * u.transpose() - Mat3::Identity();
  }
  const Vec3 v = a.cross(b);
  Mat3 k;
  k << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return Mat3::Identity() + k + k * k / (1 + c);
}

}  // namespace evograsp::assets

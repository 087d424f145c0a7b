#include "sim/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "sim/hull_faces.h"

namespace evograsp::sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double dot(const Vec3& a, const Vec3& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}
double length(const Vec3& a) {
  return std::sqrt(dot(a, a));
}

bool good_size(double value) {
  return std::isfinite(value) && value > 0 && value <= 10;
}

// The stretch of a ray inside a convex shape.
struct Stretch {
  double in = -kInfinity, out = kInfinity;
  void clip(double from, double to) {
    in = std::max(in, from);
    out = std::min(out, to);
  }
  bool empty() const { return !(in <= out); }
};

// Between the planes -h and h of one axis.
bool clip_slab(double origin, double direction, double h, Stretch* s) {
  if (direction == 0) return std::fabs(origin) <= h;
  const double a = (-h - origin) / direction;
  const double b = (h - origin) / direction;
  s->clip(std::min(a, b), std::max(a, b));
  return !s->empty();
}

// Inside an infinite cylinder about z. The distance of the line from the axis comes from the perpendicular
// part, which keeps its digits when the eye is far away.
bool clip_tube(const Ray& ray, double radius, Stretch* s) {
  const double dx = ray.direction.x(), dy = ray.direction.y();
  const double ox = ray.origin.x(), oy = ray.origin.y();
  const double a = dx * dx + dy * dy;
  if (a == 0) return ox * ox + oy * oy <= radius * radius;
  const double middle = -(ox * dx + oy * dy) / a;
  const double px = ox + middle * dx, py = oy + middle * dy;
  const double left = radius * radius - (px * px + py * py);
  if (left < 0) return false;
  const double half = std::sqrt(left / a);
  s->clip(middle - half, middle + half);
  return !s->empty();
}

bool ball_stretch(const Ray& ray, const Vec3& centre, double radius, Stretch* s) {
  const Vec3 o = ray.origin - centre;
  const double a = dot(ray.direction, ray.direction);
  const double middle = -dot(o, ray.direction) / a;
  const Vec3 p = o + middle * ray.direction;
  const double left = radius * radius - dot(p, p);
  if (left < 0) return false;
  const double half = std::sqrt(left / a);
  s->in = middle - half, s->out = middle + half;
  return true;
}

Ray into(const Pose& X_BP, const Ray& ray) {
  const Mat3& r = X_BP.rotation;
  const Vec3 o = ray.origin - X_BP.position;
  return {Vec3(dot(r.col(0), o), dot(r.col(1), o), dot(r.col(2), o)),
          Vec3(dot(r.col(0), ray.direction), dot(r.col(1), ray.direction), dot(r.col(2), ray.direction))};
}

}  // namespace

bool BoundingBall::touches(const Ray& ray) const {
  const Vec3 o = ray.origin - centre;
  const double a = dot(ray.direction, ray.direction);
  const double b = dot(o, ray.direction);
  return (dot(o, o) - radius * radius) * a <= b * b;
}

Result<Solid> Solid::create(const proto::ConvexPart& part) {
  Solid solid;
  solid.X_BP_ = from_proto(part.pose());
  solid.rounding_ = part.rounding();
  if (!is_finite(solid.X_BP_) || !std::isfinite(solid.rounding_) || solid.rounding_ < 0)
    return fail(ErrorCode::kInvalid, "a part's pose and rounding must be finite");
  if (part.has_box()) {
    solid.kind_ = Kind::kBox;
    solid.size_ = Vec3(part.box().hx(), part.box().hy(), part.box().hz());
  } else if (part.has_ball()) {
    solid.kind_ = Kind::kBall;
    solid.size_ = Vec3::Constant(part.ball().radius());
  } else if (part.has_cylinder() || part.has_capsule()) {
    solid.kind_ = part.has_cylinder() ? Kind::kCylinder : Kind::kCapsule;
    const auto& rod = part.has_cylinder() ? part.cylinder() : part.capsule();
    solid.size_ = Vec3(rod.radius(), rod.radius(), rod.half_length());
  } else if (part.has_hull()) {
    solid.kind_ = Kind::kHull;
    if (Status s = build_faces(solid, part.hull()); !s) return tl::unexpected(s.error());
    return solid;
  } else {
    return fail(ErrorCode::kInvalid, "a part has no shape");
  }
  if (!good_size(solid.size_.x()) || !good_size(solid.size_.y()) || !good_size(solid.size_.z()))
    return fail(ErrorCode::kInvalid, "a part's sizes must be above 0 and at most 10 m");
  const Vec3& h = solid.size_;
  solid.ball_.centre = solid.X_BP_.position;
  switch (solid.kind_) {
    case Kind::kBall:
      solid.ball_.radius = h.x();
      break;
    case Kind::kCapsule:
      solid.ball_.radius = h.x() + h.z();
      break;
    case Kind::kCylinder:
      solid.ball_.radius = std::sqrt(h.x() * h.x() + h.z() * h.z());
      break;
    default:
      solid.ball_.radius = length(h);
      break;
  }
  solid.ball_.radius += 1e-9;
  return solid;
}

namespace {

// A flat core is a body once it is swept by a ball: here by the ball's six poles.
proto::ConvexPart::Hull thickened(const proto::ConvexPart::Hull& flat, double by) {
  proto::ConvexPart::Hull out;
  for (int i = 0; i + 2 < flat.xyz_size(); i += 3) {
    for (int pole = 0; pole < 6; ++pole) {
      for (int axis = 0; axis < 3; ++axis)
        out.add_xyz(flat.xyz(i + axis) + (pole / 2 == axis ? (pole % 2 == 0 ? by : -by) : 0));
    }
  }
  return out;
}

}  // namespace

Status build_faces(Solid& solid, const proto::ConvexPart::Hull& hull) {
  Result<HullFaces> faces = hull_faces(hull);
  double sweep = solid.rounding_;
  if (!faces) {
    faces = hull_faces(thickened(hull, std::max(sweep, 1e-5)));
    sweep = 0;
  }
  if (!faces) return tl::unexpected(faces.error());
  solid.vertices_ = std::move(faces->vertices);
  for (const HullFaces::Plane& plane : faces->planes)
    solid.planes_.push_back({plane.normal, plane.offset + sweep});
  Vec3 low = solid.vertices_[0], high = low;
  for (const Vec3& v : solid.vertices_) low = low.cwiseMin(v), high = high.cwiseMax(v);
  const Vec3 centre = 0.5 * (low + high);
  double far2 = 0;
  for (const Vec3& v : solid.vertices_) far2 = std::max(far2, dot(v - centre, v - centre));
  solid.size_ = 0.5 * (high - low);
  solid.ball_ = {solid.X_BP_ * centre, std::sqrt(far2) + 2 * solid.rounding_ + 1e-9};
  return {};
}

bool Solid::enter_box(const Ray& ray, double* t) const {
  Stretch s;
  for (int k = 0; k < 3; ++k)
    if (!clip_slab(ray.origin[k], ray.direction[k], size_[k], &s)) return false;
  *t = s.in;
  return true;
}

bool Solid::enter_rod(const Ray& ray, double* t) const {
  Stretch tube;
  bool hit =
      clip_tube(ray, size_.x(), &tube) && clip_slab(ray.origin.z(), ray.direction.z(), size_.z(), &tube);
  *t = hit ? tube.in : kInfinity;
  if (kind_ == Kind::kCylinder) return hit;
  for (const double z : {-size_.z(), size_.z()}) {
    Stretch cap;
    if (!ball_stretch(ray, Vec3(0, 0, z), size_.x(), &cap)) continue;
    *t = std::min(*t, cap.in);
    hit = true;
  }
  return hit;
}

bool Solid::enter_hull(const Ray& ray, double* t) const {
  Stretch s;
  for (const Plane& plane : planes_) {
    const double rate = dot(plane.normal, ray.direction);
    const double room = plane.offset - dot(plane.normal, ray.origin);
    if (rate == 0) {
      if (room < 0) return false;
    } else if (rate < 0) {
      s.in = std::max(s.in, room / rate);
    } else {
      s.out = std::min(s.out, room / rate);
    }
    if (s.empty()) return false;
  }
  *t = s.in;
  return true;
}

bool Solid::enter(const Ray& ray_B, double t_min, double t_max, double* t) const {
  if (!ball_.touches(ray_B)) return false;
  const Ray ray = into(X_BP_, ray_B);
  double at = 0;
  bool hit = false;
  switch (kind_) {
    case Kind::kBox:
      hit = enter_box(ray, &at);
      break;
    case Kind::kBall: {
      Stretch s;
      hit = ball_stretch(ray, Vec3::Zero(), size_.x(), &s);
      at = s.in;
      break;
    }
    case Kind::kCylinder:
    case Kind::kCapsule:
      hit = enter_rod(ray, &at);
      break;
    case Kind::kHull:
      hit = enter_hull(ray, &at);
      break;
  }
  if (!hit || !(at > t_min && at < t_max)) return false;
  *t = at;
  return true;
}

Vec3 Solid::normal(const Vec3& p_B, double bevel_m) const {
  const Vec3 p = into(X_BP_, {p_B, Vec3::Zero()}).origin;
  Vec3 n = Vec3::UnitZ();
  const double bevel = std::min(bevel_m + 1e-7, 0.5 * size_.minCoeff());
  switch (kind_) {
    case Kind::kBall:
      n = p;
      break;
    case Kind::kCapsule:
      n = p - Vec3(0, 0, std::clamp(p.z(), -size_.z(), size_.z()));
      break;
    case Kind::kBox: {
      for (int k = 0; k < 3; ++k) n[k] = p[k] - std::clamp(p[k], bevel - size_[k], size_[k] - bevel);
      break;
    }
    case Kind::kCylinder: {
      const double radial = std::sqrt(p.x() * p.x() + p.y() * p.y());
      const double side = std::max(0.0, radial - (size_.x() - bevel));
      const double scale = radial > 0 ? side / radial : 0;
      n = Vec3(p.x() * scale, p.y() * scale, p.z() - std::clamp(p.z(), bevel - size_.z(), size_.z() - bevel));
      break;
    }
    case Kind::kHull: {
      double closest = -kInfinity;
      for (const Plane& plane : planes_) closest = std::max(closest, dot(plane.normal, p) - plane.offset);
      n.setZero();  // faces within the bevel share an edge's normal
      for (const Plane& plane : planes_)
        n += plane.normal * std::max(0.0, dot(plane.normal, p) - plane.offset - closest + bevel);
      break;
    }
  }
  const double size = length(n);
  return X_BP_.rotation * (size > 0 ? Vec3(n / size) : Vec3(Vec3::UnitZ()));
}

Vec3 Solid::support(const Vec3& direction_B) const {
  const Vec3 d = into(X_BP_, {Vec3::Zero(), direction_B}).direction;
  Vec3 p = Vec3::Zero();
  const auto to = [](double along, double half) { return along < 0 ? -half : half; };
  switch (kind_) {
    case Kind::kBox:
      p = Vec3(to(d.x(), size_.x()), to(d.y(), size_.y()), to(d.z(), size_.z()));
      break;
    case Kind::kBall:
      p = length(d) > 0 ? Vec3(d * (size_.x() / length(d))) : p;
      break;
    case Kind::kCylinder: {
      const double radial = std::sqrt(d.x() * d.x() + d.y() * d.y());
      const double scale = radial > 0 ? size_.x() / radial : 0;
      p = Vec3(d.x() * scale, d.y() * scale, to(d.z(), size_.z()));
      break;
    }
    case Kind::kCapsule: {
      p = length(d) > 0 ? Vec3(d * (size_.x() / length(d))) : p;
      p.z() += to(d.z(), size_.z());
      break;
    }
    case Kind::kHull: {
      double best = -kInfinity;
      for (const Vec3& v : vertices_)
        if (const double along = dot(v, d); along > best) best = along, p = v;
      if (length(d) > 0) p += d * (rounding_ / length(d));
      break;
    }
  }
  return X_BP_ * p;
}

}  // namespace evograsp::sim

#include "sim/quality.h"

#include <Eigen/Geometry>
#include <cmath>

#include "common/det_math.h"

namespace evograsp::sim {
namespace {

// Below this part of the torque scale a tangential offset is noise, not a direction.
constexpr double kShort = 1e-3;

Vec3 tangential(const Vec3& v, const Vec3& normal) {
  return v - v.dot(normal) * normal;
}

// Where edge 0 of the cone of contact i points: see Quality::wrenches().
Vec3 reference_tangent(std::span<const Contact> contacts, std::size_t i, const Vec3& com, double rho) {
  const Contact& contact = contacts[i];
  Vec3 best = tangential(contact.point - com, contact.normal);
  double length = best.norm();
  if (length > kShort * rho) return best / length;
  length = 0;
  for (const Contact& other : contacts) {
    const Vec3 way = tangential(other.point - contact.point, contact.normal);
    // Beyond rounding: equally far contacts of a symmetric set must not swap when the set is moved.
    if (way.norm() > length * (1 + 1e-6)) {
      best = way;
      length = way.norm();
    }
  }
  if (length > kShort * rho) return best / length;
  // Every contact on one line through the centre of mass: epsilon is 0 whatever the pyramid.
  const Vec3 axis = std::fabs(contact.normal.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY();
  return tangential(axis, contact.normal).normalized();
}

}  // namespace

Quality::Quality(const ConeModel& cone, double min_quality) : cone_(cone), min_quality_(min_quality) {
  circle_.resize(cone.edges);
  for (int k = 0; k < cone.edges; ++k) {
    det::sincos(2 * det::kPi * k / cone.edges, &circle_[k][1], &circle_[k][0]);
  }
}

std::span<const Wrench> Quality::wrenches(std::span<const Contact> contacts, const Vec3& com, double rho) {
  wrenches_.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    const Vec3 u = reference_tangent(contacts, i, com, rho);
    const Vec3 v = contact.normal.cross(u);
    const Vec3 arm = (contact.point - com) / rho;
    const double scale = cone_.unit_length ? 1 / std::sqrt(1 + contact.mu * contact.mu) : 1;
    for (const auto& [cosine, sine] : circle_) {
      const Vec3 force = scale * (contact.normal + contact.mu * (cosine * u + sine * v));
      const Vec3 torque = arm.cross(force);
      wrenches_.push_back({force.x(), force.y(), force.z(), torque.x(), torque.y(), torque.z()});
    }
  }
  return wrenches_;
}

double Quality::operator()(std::span<const Contact> contacts, const Vec3& com, double rho) {
  if (contacts.size() < 3) return 0;
  const double epsilon = epsilon_(wrenches(contacts, com, rho));
  return epsilon >= min_quality_ ? epsilon : 0;
}

}  // namespace evograsp::sim

#include "assets/solid.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "common/det_math.h"

namespace evograsp::assets {
namespace {

// What a unit-volume-scaled point mass at d from the reference adds (parallel axes theorem).
Mat3 steiner(double volume, const Vec3& d) {
  return volume * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
}

Solid combine(const Solid& a, const Solid& b, double sign) {
  Solid sum;
  sum.volume = a.volume + sign * b.volume;
  if (!(sum.volume > 0)) return {};
  sum.centre = (a.volume * a.centre + sign * b.volume * b.centre) / sum.volume;
  sum.inertia = a.inertia + steiner(a.volume, a.centre - sum.centre) +
                sign * (b.inertia + steiner(b.volume, b.centre - sum.centre));
  return sum;
}

}  // namespace

Solid Solid::moved(const Pose& pose) const {
  return {volume, pose * centre, pose.rotation * inertia * pose.rotation.transpose()};
}
Solid Solid::plus(const Solid& other) const {
  return combine(*this, other, 1);
}
Solid Solid::minus(const Solid& other) const {
  return combine(*this, other, -1);
}

bool Solid::is_body() const {
  const double sum = inertia.trace() / 2;
  if (!(volume > 0 && sum > 0) || !std::isfinite(volume) || !is_finite(centre) || !inertia.allFinite())
    return false;
  // Of the second moments about the centre, which must be positive in every direction.
  constexpr double kFlat = 1e-12;
  const Mat3 moments = (1 - kFlat) * Mat3::Identity() - inertia / sum;
  return Eigen::LLT<Mat3>(moments).info() == Eigen::Success;
}

Solid solid_box(double x, double y, double z) {
  Solid s;
  s.volume = x * y * z;
  s.inertia.diagonal() = s.volume / 12 * Vec3(y * y + z * z, x * x + z * z, x * x + y * y);
  return s;
}

Solid solid_cylinder(double radius, double height) {
  Solid s;
  s.volume = det::kPi * radius * radius * height;
  const double across = (3 * radius * radius + height * height) / 12;
  s.inertia.diagonal() = s.volume * Vec3(across, across, radius * radius / 2);
  return s;
}

Solid solid_sphere(double radius) {
  Solid s;
  s.volume = 4.0 / 3 * det::kPi * radius * radius * radius;
  s.inertia.diagonal() = Vec3::Constant(s.volume * 0.4 * radius * radius);
  return s;
}

}  // namespace evograsp::assets

#include "common/pose.h"

#include <cmath>

#include "common/det_math.h"

namespace evograsp {

Mat3 rotation_about(const Vec3& u, double angle_rad) {
  double s, c;
  det::sincos(angle_rad, &s, &c);
  const double t = 1 - c;
  Mat3 r;
  r << c + t * u.x() * u.x(), t * u.x() * u.y() - s * u.z(), t * u.x() * u.z() + s * u.y(),
      t * u.x() * u.y() + s * u.z(), c + t * u.y() * u.y(), t * u.y() * u.z() - s * u.x(),
      t * u.x() * u.z() - s * u.y(), t * u.y() * u.z() + s * u.x(), c + t * u.z() * u.z();
  return r;
}

Mat3 axis_angle(const Vec3& axis, double angle_rad) {
  const double length = std::sqrt(axis.x() * axis.x() + axis.y() * axis.y() + axis.z() * axis.z());
  if (length < 1e-9) return Mat3::Identity();
  return rotation_about(axis / length, angle_rad);
}

Mat3 rotation_from_quaternion(double w, double x, double y, double z) {
  const double n2 = w * w + x * x + y * y + z * z;
  if (!(n2 > 1e-24)) return Mat3::Identity();
  const double s = 2 / n2;
  Mat3 r;
  r << 1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), s * (x * y + z * w),
      1 - s * (x * x + z * z), s * (y * z - x * w), s * (x * z - y * w), s * (y * z + x * w),
      1 - s * (x * x + y * y);
  return r;
}

bool is_finite(const Vec3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

bool is_finite(const Pose& pose) {
  return is_finite(pose.position) && is_finite(Vec3(pose.rotation.col(0))) &&
         is_finite(Vec3(pose.rotation.col(1))) && is_finite(Vec3(pose.rotation.col(2)));
}

proto::Vec3 to_proto(const Vec3& v) {
  proto::Vec3 out;
  out.set_x(v.x());
  out.set_y(v.y());
  out.set_z(v.z());
  return out;
}

// Shepperd's method: divides by the largest of the four components.
proto::Quat to_proto(const Mat3& m) {
  double w, x, y, z;
  const double trace = m(0, 0) + m(1, 1) + m(2, 2);
  if (trace > 0) {
    const double s = 2 * std::sqrt(trace + 1);
    w = s / 4, x = (m(2, 1) - m(1, 2)) / s, y = (m(0, 2) - m(2, 0)) / s, z = (m(1, 0) - m(0, 1)) / s;
  } else if (m(0, 0) > m(1, 1) && m(0, 0) > m(2, 2)) {
    const double s = 2 * std::sqrt(1 + m(0, 0) - m(1, 1) - m(2, 2));
    w = (m(2, 1) - m(1, 2)) / s, x = s / 4, y = (m(0, 1) + m(1, 0)) / s, z = (m(0, 2) + m(2, 0)) / s;
  } else if (m(1, 1) > m(2, 2)) {
    const double s = 2 * std::sqrt(1 + m(1, 1) - m(0, 0) - m(2, 2));
    w = (m(0, 2) - m(2, 0)) / s, x = (m(0, 1) + m(1, 0)) / s, y = s / 4, z = (m(1, 2) + m(2, 1)) / s;
  } else {
    const double s = 2 * std::sqrt(1 + m(2, 2) - m(0, 0) - m(1, 1));
    w = (m(1, 0) - m(0, 1)) / s, x = (m(0, 2) + m(2, 0)) / s, y = (m(1, 2) + m(2, 1)) / s, z = s / 4;
  }
  proto::Quat out;
  out.set_w(w);
  out.set_x(x);
  out.set_y(y);
  out.set_z(z);
  return out;
}

proto::Pose to_proto(const Pose& pose) {
  proto::Pose out;
  *out.mutable_position() = to_proto(pose.position);
  *out.mutable_orientation() = to_proto(pose.rotation);
  return out;
}

Vec3 from_proto(const proto::Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
Mat3 from_proto(const proto::Quat& q) {
  return rotation_from_quaternion(q.w(), q.x(), q.y(), q.z());
}
Pose from_proto(const proto::Pose& pose) {
  return {from_proto(pose.orientation()), from_proto(pose.position())};
}

}  // namespace evograsp

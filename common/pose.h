// Rigid poses. X_AB maps coordinates in frame B to frame A; p_A a position in frame A. Metres, radians.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/result.h"
#include "proto/geometry.pb.h"

namespace evograsp {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 position = Vec3::Zero();

  Vec3 operator*(const Vec3& p) const { return rotation * p + position; }
  Pose operator*(const Pose& b) const { return {rotation * b.rotation, rotation * b.position + position}; }
  Pose inverse() const { return {rotation.transpose(), -(rotation.transpose() * position)}; }
};

// Rotation by angle_rad about a unit axis (Rodrigues), with reproducible sine and cosine.
Mat3 rotation_about(const Vec3& unit_axis, double angle_rad);
// Rotation by angle_rad about axis of any length; a zero axis (below 1e-9) means no rotation.
Mat3 axis_angle(const Vec3& axis, double angle_rad);
Mat3 rotation_from_quaternion(double w, double x, double y,
                              double z);  // normalises; identity for a zero quaternion

bool is_finite(const Vec3& v);
bool is_finite(const Pose& pose);

proto::Vec3 to_proto(const Vec3& v);
proto::Pose to_proto(const Pose& pose);
Vec3 from_proto(const proto::Vec3& v);
Pose from_proto(const proto::Pose& pose);
Mat3 from_proto(const proto::Quat& q);
proto::Quat to_proto(const Mat3& rotation);

}  // namespace evograsp

#include "sim/camera.h"

#include <cmath>
#include <string>

#include "common/det_math.h"
#include "common/random.h"

namespace evograsp::sim {
namespace {

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}
double dot(const Vec3& a, const Vec3& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}
Vec3 unit(const Vec3& v) {
  return v / std::sqrt(dot(v, v));
}

Pose looking(const Vec3& eye, const Vec3& forward, const Vec3& up) {
  const Vec3 right = unit(cross(forward, up));
  Pose pose;
  pose.rotation.col(0) = right;
  pose.rotation.col(1) = cross(forward, right);
  pose.rotation.col(2) = forward;
  pose.position = eye;
  return pose;
}

// Image up is world z projected; looking straight up or down, it is world x.
Pose looking(const Vec3& eye, const Vec3& target) {
  const Vec3 forward = unit(target - eye);
  const bool along_z = std::fabs(forward.x()) < 1e-9 && std::fabs(forward.y()) < 1e-9;
  return looking(eye, forward, along_z ? Vec3(1, 0, 0) : Vec3(0, 0, 1));
}

constexpr std::uint64_t kPoseStream = 4000000;  // of the domain randomisation

}  // namespace

Result<Camera> Camera::create(const proto::CameraConfig& config) {
  Camera camera;
  camera.width_ = static_cast<int>(config.image_width());
  camera.height_ = static_cast<int>(config.image_height());
  camera.fx_ = config.fx(), camera.fy_ = config.fy(), camera.cx_ = config.cx(), camera.cy_ = config.cy();
  camera.near_ = config.near(), camera.far_ = config.far();
  const Vec3 eye = config.has_eye() ? from_proto(config.eye()) : Vec3(0.55, 0, 0.55);
  if (camera.width_ < 2 || camera.height_ < 2 || camera.width_ > 8192 || camera.height_ > 8192)
    return fail(ErrorCode::kInvalid, "camera: the image must have 2 to 8192 pixels a side");
  if (!(camera.fx_ >= 1 && camera.fy_ >= 1) || !std::isfinite(camera.fx_ + camera.fy_))
    return fail(ErrorCode::kInvalid, "camera: fx and fy must be at least 1 pixel");
  if (!std::isfinite(camera.cx_ + camera.cy_))
    return fail(ErrorCode::kInvalid, "camera: cx and cy must be finite");
  if (!(camera.near_ > 0 && camera.near_ < camera.far_) || !std::isfinite(camera.far_))
    return fail(ErrorCode::kInvalid, "camera: near must be above 0 and below far");
  if (!is_finite(eye) || !(dot(eye, eye) > 1e-6) || dot(eye, eye) > 1e6)
    return fail(ErrorCode::kInvalid, "camera: eye must lie 1 mm to 1 km from the origin, which it looks at");
  camera.pose_ = looking(eye, Vec3::Zero());
  camera.eye_jitter_ = config.eye_jitter(), camera.aim_jitter_ = config.aim_jitter();
  if (!(camera.eye_jitter_ >= 0 && camera.aim_jitter_ >= 0) ||
      !(std::sqrt(dot(eye, eye)) > 2 * (camera.eye_jitter_ + camera.aim_jitter_)))
    return fail(ErrorCode::kInvalid,
                "camera: eye_jitter and aim_jitter together must stay below half the eye's distance");
  return camera;
}

Camera Camera::of_placement(std::uint64_t seed) const {
  if (eye_jitter_ == 0 && aim_jitter_ == 0) return *this;
  Random random(seed, Purpose::kDomain, 0, kPoseStream);
  double move[5];
  for (double& m : move) m = random.uniform(-1, 1);
  const Vec3 eye = pose_.position + eye_jitter_ * Vec3(move[0], move[1], move[2]);
  const Vec3 aim = aim_jitter_ * Vec3(move[3], move[4], 0);
  Camera moved = *this;
  moved.pose_ = looking(eye, unit(aim - eye), -pose_.rotation.col(1));
  return moved;
}

Camera Camera::look_at(const Vec3& eye, const Vec3& target, int width, int height, double fov_height_rad) {
  Camera camera;
  camera.width_ = width, camera.height_ = height;
  double s, c;
  det::sincos(fov_height_rad / 2, &s, &c);
  camera.fx_ = camera.fy_ = height / 2.0 * c / s;
  camera.cx_ = (width - 1) / 2.0, camera.cy_ = (height - 1) / 2.0;
  camera.near_ = 0.01, camera.far_ = 100;
  camera.pose_ = looking(eye, target);
  return camera;
}

Camera Camera::resized(int width, int height) const {
  Camera out = *this;
  const double scale = static_cast<double>(height) / height_;
  out.width_ = width, out.height_ = height;
  out.fx_ *= scale, out.fy_ *= scale;
  out.cx_ = (cx_ + 0.5) * scale - 0.5 + (width - width_ * scale) / 2;
  out.cy_ = (cy_ + 0.5) * scale - 0.5;
  out.near_ = 0.01, out.far_ = 100;
  return out;
}

Ray Camera::ray(const Pixel& pixel) const {
  const double a = (pixel.u - cx_) / fx_;
  const double b = (pixel.v - cy_) / fy_;
  const Mat3& r = pose_.rotation;
  return {pose_.position, Vec3(r(0, 2) + a * r(0, 0) + b * r(0, 1), r(1, 2) + a * r(1, 0) + b * r(1, 1),
                               r(2, 2) + a * r(2, 0) + b * r(2, 1))};
}

std::optional<Pixel> Camera::project(const Vec3& p_W) const {
  const Vec3 d = p_W - pose_.position;
  const Mat3& r = pose_.rotation;
  const double z = dot(r.col(2), d);
  if (!(z > 1e-9)) return std::nullopt;
  return Pixel{cx_ + fx_ * (dot(r.col(0), d) / z), cy_ + fy_ * (dot(r.col(1), d) / z)};
}

float Camera::normalise(double depth_m) const {
  const double s = (depth_m - near_) / (far_ - near_);
  return static_cast<float>(s < 0 ? 0 : s > 1 ? 1 : s);
}

}  // namespace evograsp::sim

#include "sim/image_bounds.h"

#include <algorithm>
#include <array>

namespace evograsp::sim {
namespace {

double dot(const Vec3& a, const Vec3& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

// The largest of (axis . p) / (forward . p) over the part, coordinates from the eye. Nothing when it reaches
// the camera's plane.
std::optional<double> largest_ratio(const Solid& part, const Vec3& axis, const Vec3& forward,
                                    const Vec3& eye) {
  constexpr double kNearest = 1e-6;
  const Vec3 nearest = part.support(-forward);
  if (!(dot(forward, nearest - eye) > kNearest)) return std::nullopt;
  double ratio = dot(axis, nearest - eye) / dot(forward, nearest - eye);
  for (int i = 0; i < 50; ++i) {
    const Vec3 p = part.support(axis - ratio * forward) - eye;
    const double next = dot(axis, p) / dot(forward, p);
    if (!(next > ratio + 1e-13)) break;
    ratio = next;
  }
  return ratio;
}

}  // namespace

std::optional<ImageBox> ImageBounds::project(const Camera& camera, const Pose& X_WB, double scale) const {
  const Mat3 r = X_WB.rotation.transpose() * camera.pose().rotation;  // camera axes in the body frame
  // A body twice as large looks as it does from half as far.
  const Vec3 eye = (X_WB.inverse() * camera.eye()) / scale;
  const Vec3 right = r.col(0), down = r.col(1), forward = r.col(2);
  const std::array<Vec3, 4> axes = {Vec3(-right), right, Vec3(-down), down};
  std::array<double, 4> extreme = {-1e300, -1e300, -1e300, -1e300};
  for (const Solid& part : parts_)
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const std::optional<double> ratio = largest_ratio(part, axes[k], forward, eye);
      if (!ratio) return std::nullopt;
      extreme[k] = std::max(extreme[k], *ratio);
    }
  if (parts_.empty()) return std::nullopt;
  return ImageBox{camera.cx() - camera.fx() * extreme[0], camera.cy() - camera.fy() * extreme[2],
                  camera.cx() + camera.fx() * extreme[1], camera.cy() + camera.fy() * extreme[3]};
}

}  // namespace evograsp::sim

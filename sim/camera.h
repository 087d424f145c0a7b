// A pinhole camera that looks at the world origin.
//
// Camera frame C: x right, y down, z along the optical axis. Pixel coordinates (u, v): u to the right, v
// down, the centre of the top left pixel is (0, 0), so that an image of w x h pixels spans [-0.5, w - 0.5] x
// [-0.5, h - 0.5]. The world origin lies on the optical axis: it lands on (cx, cy).
#pragma once

#include <cstdint>
#include <optional>

#include "common/pose.h"
#include "common/result.h"
#include "proto/config.pb.h"

namespace evograsp::sim {

struct Pixel {
  double u = 0, v = 0;
};

// A ray scaled so that `direction` advances one metre along the optical axis: its parameter is depth.
struct Ray {
  Vec3 origin = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();
  Vec3 at(double t) const { return origin + t * direction; }
};

// Immutable and thread-safe; a value.
class Camera {
 public:
  // Errors: an eye at the origin, not finite or straight above with no image-up direction is resolved (up =
  // +x of the world when looking along z); near >= far and sizes out of range are refused.
  static Result<Camera> create(const proto::CameraConfig& config);
  // The same intrinsics rules for a picture from any viewpoint: looks from eye at target, `fov_height_rad`
  // tall.
  static Camera look_at(const Vec3& eye, const Vec3& target, int width, int height, double fov_height_rad);

  // The camera of one placement: its seed moves the eye and the point looked at by the config's jitter; roll
  // stays.
  Camera of_placement(std::uint64_t seed) const;

  // The same view on another number of pixels, cut or widened at the sides where the shape differs; sees from
  // 1 cm on.
  Camera resized(int width, int height) const;

  int width() const { return width_; }
  int height() const { return height_; }
  double near() const { return near_; }
  double far() const { return far_; }
  double fx() const { return fx_; }
  double fy() const { return fy_; }
  double cx() const { return cx_; }
  double cy() const { return cy_; }
  const Pose& pose() const { return pose_; }  // X_WC
  const Vec3& eye() const { return pose_.position; }

  Ray ray(const Pixel& pixel) const;
  // Nothing for points on or behind the camera's plane.
  std::optional<Pixel> project(const Vec3& p_W) const;
  double depth(const Vec3& p_W) const { return pose_.rotation.col(2).dot(p_W - pose_.position); }
  // [near, far] to [0, 1], clamped.
  float normalise(double depth_m) const;

 private:
  int width_ = 0, height_ = 0;
  double fx_ = 0, fy_ = 0, cx_ = 0, cy_ = 0, near_ = 0, far_ = 0;
  double eye_jitter_ = 0, aim_jitter_ = 0;
  Pose pose_;
};

}  // namespace evograsp::sim

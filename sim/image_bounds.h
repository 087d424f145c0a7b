// The image-space box of a body: how far its projection reaches.
#pragma once

#include <optional>
#include <vector>

#include "proto/bundle.pb.h"
#include "sim/camera.h"
#include "sim/solid.h"

namespace evograsp::sim {

// A rectangle in pixel coordinates.
struct ImageBox {
  double left = 0, top = 0, right = 0, bottom = 0;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
  // Wholly within the image's pixels.
  bool inside(const Camera& camera) const {
    return left >= -0.5 && top >= -0.5 && right <= camera.width() - 0.5 && bottom <= camera.height() - 0.5;
  }
};

// The convex parts of one body, ready to be projected. Immutable and thread-safe.
class ImageBounds {
 public:
  ImageBounds() = default;
  explicit ImageBounds(std::vector<Solid> parts) : parts_(std::move(parts)) {}

  // The tightest box around the projection of the body at X_WB, `scale` times as large, exact to 1e-9 pixels:
  // each side maximises the ratio (n . p) / depth over the parts by Dinkelbach's iteration on their support
  // points (Dinkelbach, Management Science 13, 1967). Nothing when a part reaches the camera's plane.
  std::optional<ImageBox> project(const Camera& camera, const Pose& X_WB, double scale = 1) const;

 private:
  std::vector<Solid> parts_;
};

}  // namespace evograsp::sim

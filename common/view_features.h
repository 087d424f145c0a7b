// How long a network's input vector is. The features themselves are made in sim/view_features.h.
#pragma once

#include <cstdint>

#include "proto/config.pb.h"

namespace evograsp {

inline constexpr std::uint32_t kClickAndBoxInputs = 4;  // a, b, w, h

constexpr std::uint32_t feature_size(proto::ViewFeature feature) {
  return feature == proto::AXIS ? 2 : 3;
}

// Inputs behind the depth samples: click, box and the configured features.
inline std::uint32_t other_inputs(const proto::CameraConfig& camera) {
  std::uint32_t count = kClickAndBoxInputs;
  for (const int feature : camera.feature()) count += feature_size(static_cast<proto::ViewFeature>(feature));
  return count;
}

inline std::uint32_t network_inputs(const proto::CameraConfig& camera) {
  return camera.columns() * camera.rows() + other_inputs(camera);
}

}  // namespace evograsp

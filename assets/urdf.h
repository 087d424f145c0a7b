// URDF text, parsed by urdfdom behind bounds: a hostile file gives an error, never a crash.
#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <string>
#include <string_view>

#include "common/pose.h"
#include "common/result.h"

namespace evograsp::assets {

inline constexpr std::size_t kMaxUrdf = std::size_t{4} << 20;  // bytes
inline constexpr std::size_t kMaxUrdfLinks = 512;

// The model, or an error that starts with file_name and holds urdfdom's own words. Thread-safe (serialised).
Result<urdf::ModelInterfaceSharedPtr> parse_urdf(std::string_view text, const std::string& file_name);

// A URDF pose with its rotation snapped to a grid of 2^-40: urdfdom computes it with the C library's sine and
// cosine, whose last bit depends on the machine.
Pose snapped(const urdf::Pose& pose);

}  // namespace evograsp::assets

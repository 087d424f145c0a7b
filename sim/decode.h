// The network's answer as a pose.
#pragma once

#include <span>

#include "common/pose.h"
#include "proto/bundle.pb.h"
#include "proto/config.pb.h"
#include "sim/simulator.h"

namespace evograsp::sim {

// Palm orientation R_WH at zero rotation: GraspConfig.home, by default the hand's approach axis down (-z of
// the world) and its finger axis along -x. The two axes of a hand need not be perpendicular: the approach
// axis is met exactly.
Mat3 home_rotation(const proto::GraspConfig& config, const proto::HandBundle& hand);

// Outputs (x, y, z, axis x, y, z, angle), each in [-1, 1], as a tool pose X_WT: position = info.anchor +
// (x, y, z) * half, half = workspace_box_half with the bounding box, workspace_half without; rotation = the
// angle (times pi) about the normalised axis, applied to `home`; a zero axis means no rotation. Outputs that
// are not finite give a pose that is not finite.
// `frame` (pose_frame in sim/view_features.h) turns both, the position about the anchor.
Pose decode_pose(const proto::GraspConfig& config, const Mat3& home, std::span<const float> outputs,
                 const Info& info, bool bounding_box, const Mat3& frame = Mat3::Identity());

}  // namespace evograsp::sim

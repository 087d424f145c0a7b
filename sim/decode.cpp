#include "sim/decode.h"

#include <cmath>
#include <limits>

#include "common/det_math.h"

namespace evograsp::sim {
namespace {

Vec3 or_default(bool present, const proto::Vec3& value, const Vec3& otherwise) {
  return present ? from_proto(value) : otherwise;
}

// Columns: first axis, the part of the second perpendicular to it, their cross product.
Mat3 frame_of(const Vec3& first, const Vec3& second) {
  Mat3 frame;
  frame.col(0) = first / std::sqrt(first.dot(first));
  const Vec3 across = second - frame.col(0) * frame.col(0).dot(second);
  frame.col(1) = across / std::sqrt(across.dot(across));
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

}  // namespace

Mat3 home_rotation(const proto::GraspConfig& config, const proto::HandBundle& hand) {
  if (config.has_home()) return from_proto(config.home().orientation());
  const Vec3 approach = or_default(hand.has_approach_axis(), hand.approach_axis(), Vec3(0, 0, 1));
  const Vec3 fingers = or_default(hand.has_finger_axis(), hand.finger_axis(), Vec3(1, 0, 0));
  return frame_of(Vec3(0, 0, -1), Vec3(-1, 0, 0)) * frame_of(approach, fingers).transpose();
}

Pose decode_pose(const proto::GraspConfig& config, const Mat3& home, std::span<const float> outputs,
                 const Info& info, bool bounding_box, const Mat3& frame) {
  const Vec3 half =
      bounding_box
          ? or_default(config.has_workspace_box_half(), config.workspace_box_half(), Vec3(0.15, 0.15, 0.15))
          : or_default(config.has_workspace_half(), config.workspace_half(), Vec3(0.3, 0.3, 0.125));
  double value[kOutputs];
  bool finite = true;
  for (int i = 0; i < kOutputs; ++i) {
    value[i] = outputs[static_cast<std::size_t>(i)];
    finite = finite && std::isfinite(value[i]);
  }
  Pose tool;
  if (!finite) {
    tool.position.setConstant(std::numeric_limits<double>::quiet_NaN());
    return tool;
  }
  tool.position = info.anchor + frame * Vec3(value[0] * half.x(), value[1] * half.y(), value[2] * half.z());
  tool.rotation = frame * axis_angle(Vec3(value[3], value[4], value[5]), det::kPi * value[6]) * home;
  return tool;
}

}  // namespace evograsp::sim

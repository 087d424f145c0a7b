// Measurements on the depth samples that a network sees anyway: where the object about the click is, how
// large, and which way it lies. Evolution need not find moments of 300 weights then (CameraConfig.feature;
// off in the thesis's form).
//
// The object: samples whose points stand at least 6 mm above the table and within 15 cm of the clicked point,
// each weighted by its depth squared (the area it stands for); the clicked point alone when there are none.
// Spread and axis are those of the covariance of the points on the table's plane (moments; Hu 1962, equations
// 1 to 4):
//   spread = sqrt of its eigenvalues l1 >= l2, axis = (cxx - cyy, 2 cxy) / (cxx + cyy + 1 cm^2).
// Only exactly rounded operations: the same bits everywhere. Pure and thread-safe.
#pragma once

#include <span>
#include <vector>

#include "common/pose.h"
#include "proto/config.pb.h"
#include "sim/camera.h"

namespace evograsp::sim {

// The samples, as cells of a window of the camera's image.
struct SampledView {
  const Camera* camera = nullptr;
  Pixel centre;                     // of the window
  double width = 0, height = 0;     // of the window, px
  std::span<const float> depth;     // rows x columns, [near, far] as [0, 1]
  Vec3 point = Vec3::Zero();        // under the click, world
  Vec3 anchor = Vec3::Zero();       // of the position output, world
  Vec3 unit = Vec3::Constant(0.1);  // world length of one position output, m: > 0
};

// The configured features, in the order of the config.
std::vector<float> view_features(const proto::CameraConfig& config, const SampledView& view);

// The anchor with object_frame: where the ray through the middle of what is seen passes at half the object's
// height. The middle is the window's centre with the box, else the mean of the object's visible points.
// view.anchor when that ray does not descend.
Vec3 object_anchor(const proto::CameraConfig& config, const SampledView& view, bool bounding_box);

// R_WF of the frame F that poses and vectors about the anchor are given in: with object_frame turned about
// the vertical by the half of AXIS's angle and a right angle, so that x lies across the main axis, at most a
// right angle off the world's x. What is seen of a round thing is broad across the view, so that F is the
// world's there. `features` as above; without object_frame the identity.
Mat3 pose_frame(const proto::CameraConfig& config, std::span<const float> features);

// unit of SampledView: half the workspace in use.
Vec3 workspace_unit(const proto::GraspConfig& grasp, bool bounding_box);

}  // namespace evograsp::sim

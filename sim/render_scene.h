// What stands in a picture: objects where a placement puts them, a hand at given joints, contacts and
// friction cones.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "proto/bundle.pb.h"
#include "sim/render.h"
#include "sim/simulator.h"

namespace evograsp::sim {

// Poses of every link of a hand, X_WL, from the palm's pose and one value a joint (rad or m). Joints missing
// from `joints` stand at the preset, or 0.
std::vector<Pose> link_poses(const proto::HandBundle& hand, const Pose& X_WH, std::span<const double> joints);

// Errors: a bundle whose shapes cannot be drawn.
Status add_objects(RenderScene& scene, std::span<const proto::ObjectBundle> objects,
                   const Placements& placements);
Status add_hand(RenderScene& scene, const proto::HandBundle& hand, const Pose& X_WH,
                std::span<const double> joints);
// A dot at each contact and its friction cone: half angle atan(mu), about the normal, inside the target.
Status add_contacts(RenderScene& scene, std::span<const Contact> contacts);

// A ball that a picture is about.
struct Subject {
  Vec3 centre = Vec3::Zero();
  double radius = 0.14;  // m
};
// The objects of a scene.
Subject subject_of(std::span<const proto::ObjectBundle> objects, const Placements& placements);

// A named viewpoint: "corner", "front" (from +x), "side" (from -y), "top", "camera" (the depth camera's own),
// or eye coordinates "x y z" in metres. All but "camera" look at the subject; the named ones stand so far
// that it fills the picture.
Result<Camera> choose_view(const std::string& view, const Camera& depth_camera, const Subject& subject,
                           int width, int height);

}  // namespace evograsp::sim

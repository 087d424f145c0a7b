// The depth camera: cmd_get_info.
#pragma once

#include <memory>
#include <vector>

#include "common/random.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "proto/wire.pb.h"
#include "sim/camera.h"
#include "sim/image_bounds.h"
#include "sim/ray_caster.h"
#include "sim/simulator.h"

namespace evograsp::sim {

// Immutable and thread-safe.
class DepthCamera {
 public:
  // Objects in scene order. Errors name the object and the part that cannot be seen.
  static Result<DepthCamera> create(const proto::Experiment& experiment,
                                    const std::vector<proto::ObjectBundle>& objects);

  const Camera& camera() const { return camera_; }  // as configured, without jitter
  const RayCaster& caster() const { return caster_; }

  // cmd_get_info. depth: columns x rows rays through the centres of the cells that divide the whole image, or
  // with the box the window of box_width x box_height pixels about the projection of the target's centre of
  // mass (which may reach past the image), row by row from the top left; each the depth along the optical
  // axis, [near, far] mapped to [0, 1], 1 without return. click: see draw_click(). box_w, box_h: the target's
  // projected size over the image's. anchor: with the box the first surface point on the ray through the
  // window's centre (at `far` without return), else GraspConfig.workspace_centre. Errors: no such target or
  // not in this scene, no pixel of it visible.
  Result<Info> look(const Placements& placements, int target, int click, bool bounding_box) const;
  // The depth samples alone, without noise; `target` must be in the scene and before the camera.
  void render(const Placements& placements, int target, bool bounding_box, std::vector<float>* depth) const;

 private:
  // What one placement looks like.
  struct View {
    Camera camera;
    PosedScene scene;
    Pixel centre;  // of the target's centre of mass
  };
  Result<Pixel> draw_click(const View& view, const ImageBox& box, std::uint64_t seed, int target,
                           int click) const;
  Ray cell_ray(const View& view, bool bounding_box, int column, int row) const;
  void sample(const View& view, bool bounding_box, Random* noise, std::vector<float>* depth) const;
  PosedScene posed(const Placements& placements) const;
  Vec3 centre_of(const Placements& placements, std::size_t object) const;
  void measure_view(const Pixel& centre, bool bounding_box, Info* info) const;

  proto::CameraConfig config_;
  Vec3 workspace_centre_ = Vec3::Zero();
  Vec3 box_unit_ = Vec3::Zero(), workspace_unit_ = Vec3::Zero();  // of the position output, m
  Camera camera_;
  RayCaster caster_;
  std::vector<Vec3> centre_of_mass_;  // body frame
  std::vector<ImageBounds> bounds_;
};

}  // namespace evograsp::sim

// The table and where the objects stand on it: cmd_shuffle.
#pragma once

#include <cstdint>
#include <vector>

#include "common/result.h"
#include "proto/bundle.pb.h"
#include "proto/config.pb.h"
#include "sim/camera.h"
#include "sim/image_bounds.h"
#include "sim/simulator.h"

namespace evograsp::sim {

// Immutable and thread-safe.
class Scene {
 public:
  // Errors name the object: no resting pose, a footprint that is no number or wider than the table.
  static Result<Scene> create(const proto::SceneConfig& config, const Camera& camera,
                              const std::vector<proto::ObjectBundle>& objects);

  // cmd_shuffle: for each object in the scene (common/scene_subset.h) a resting pose, a yaw in [-pi, pi) and
  // a position uniform in the placement area, such that
  //   - the footprint circles of any two objects are `clearance` apart (footprint_radius holds an object in
  //   every
  //     resting pose, so circles apart are bodies apart),
  //   - the whole projection of every object lies inside the camera's image.
  // Objects are placed in scene order, each by rejection; a layout that leaves no room for the next object is
  // begun again. Absent objects keep the identity pose. With size_jitter the seed draws each object's size
  // first, from streams of its own: where things stand changes only as far as their sizes make it. After
  // placement_tries draws in all: an error that names the object which found no room and what to change.
  Result<Placements> shuffle(std::uint64_t seed) const;

 private:
  struct Item {
    std::string name;
    double footprint = 0;
    std::vector<Mat3> rotation;
    std::vector<double> height;
    ImageBounds bounds;
  };
  bool fits(std::size_t index, const Placements& placements, const Camera& camera) const;

  proto::SceneConfig config_;
  Camera camera_;
  std::vector<Item> items_;
};

}  // namespace evograsp::sim

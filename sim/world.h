// What a hand can run into: the table and the parts of the objects, where a placement put them.
#pragma once

#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/wire.pb.h"
#include "sim/gjk.h"
#include "sim/shape.h"
#include "sim/simulator.h"

namespace evograsp::sim {

inline constexpr int kTableObject = -1;          // Obstacle::object of the table
inline constexpr double kTableThickness = 0.05;  // m; its top is z = 0

// A posed convex shape with its bounds.
struct Obstacle {
  const Shape* shape = nullptr;
  Pose pose;
  Aabb box;
  int object = kTableObject;
  int part = 0;
};

// Exact distance of a posed shape from an obstacle. The table is answered in closed form wherever the lowest
// point of the shape is above it.
Separation distance(const Shape& shape, const Pose& pose, const Obstacle& obstacle,
                    const DistanceOptions& options = {});

// The obstacles of one placement, each as large as it says: obstacle 0 is the table, then the objects' parts
// in scene order. Re-used from trial to trial; allocates only while it grows.
struct PosedWorld {
  struct Body {
    Aabb box;
    int first = 0, count = 0;  // its obstacles
    Vec3 centre_of_mass = Vec3::Zero();
    double torque_scale = 0;  // m
    bool present = false;
  };
  std::vector<Obstacle> obstacle;
  std::vector<Body> body;
  std::vector<Shape> sized;  // of obstacles that are not as large as modelled, at their own index
  Placements placements;     // what it was built from
};

// Immutable and thread-safe.
class World {
 public:
  static Result<World> create(const proto::SceneConfig& scene,
                              const std::vector<proto::ObjectBundle>& objects);

  // Poses everything; does nothing when `out` already stands for these placements.
  void place(const Placements& placements, PosedWorld& out) const;

  int object_count() const { return static_cast<int>(objects_.size()); }
  int part_count() const;  // obstacles of a full scene

 private:
  struct Part {
    Shape shape;
    Pose pose;
  };
  struct Object {
    std::vector<Part> part;
    Vec3 centre_of_mass = Vec3::Zero();
    double torque_scale = 0;
  };
  void place_body(std::size_t object, PosedWorld& out) const;

  std::vector<Object> objects_;
  Shape table_;
};

}  // namespace evograsp::sim

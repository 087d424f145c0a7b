// What a ray meets first: bodies of convex parts or triangles on a table.
//
// Every intersection is computed in double precision by our own code with a fixed order of operations, so
// that a depth image has the same bits on every machine. Embree serves meshes as a culling structure only
// (triangle_mesh.h).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "sim/camera.h"
#include "sim/mesh_shading.h"
#include "sim/solid.h"
#include "sim/triangle_mesh.h"

namespace evograsp::sim {

// One rigid body as rays see it. Built once; immutable and thread-safe.
class RayBody {
 public:
  // From an object: its visual mesh when it has one, else its parts.
  static Result<RayBody> create(const proto::ObjectBundle& object);
  explicit RayBody(std::vector<Solid> parts);
  explicit RayBody(std::shared_ptr<const TriangleMesh> mesh);

  const BoundingBall& ball() const { return ball_; }
  const std::vector<Solid>& parts() const { return parts_; }
  const std::shared_ptr<const TriangleMesh>& mesh() const { return mesh_; }
  // Index of the part or triangle that the ray (body frame) meets first in (t_min, *t), or -1. Equal depths:
  // the lower index.
  int enter(const Ray& ray_B, double t_min, double* t) const;
  // From now on normal() with a bevel blends a mesh's normals over its round parts. For pictures.
  void smooth();
  // Unit normal against the ray (body frame).
  Vec3 normal(const Ray& ray_B, double t, int element, double bevel_m = 0) const;

 private:
  std::vector<Solid> parts_;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::shared_ptr<const MeshShading> shading_;
  BoundingBall ball_;
};

inline constexpr int kTable = -1;
inline constexpr int kNothing = -2;

struct Hit {
  double t = 0;
  int body = kNothing;  // index, kTable or kNothing
  int element = 0;      // part or triangle
};

// The bodies of an experiment. Immutable and thread-safe; cheap to copy.
class RayCaster {
 public:
  RayCaster() = default;
  RayCaster(std::shared_ptr<const std::vector<RayBody>> bodies, double table_half_m)
      : bodies_(std::move(bodies)), table_half_(table_half_m) {}
  const std::vector<RayBody>& bodies() const { return *bodies_; }
  double table_half() const { return table_half_; }

 private:
  std::shared_ptr<const std::vector<RayBody>> bodies_;
  double table_half_ = 0;
};

// Bodies at their poses. A body that is absent is not seen. Holds no reference to the poses.
class PosedScene {
 public:
  // No `present`: all are; no `scale`: all as large as modelled.
  PosedScene(const RayCaster& caster, std::span<const Pose> X_WB, std::span<const std::uint8_t> present,
             std::span<const double> scale = {});

  // What the ray (world) meets first in (t_min, t_max).
  Hit cast(const Ray& ray_W, double t_min, double t_max) const;
  // Whether anything stands in (t_min, t_max).
  bool blocked(const Ray& ray_W, double t_min, double t_max) const;
  // Unit normal against the ray at a hit (world).
  Vec3 normal(const Ray& ray_W, const Hit& hit, double bevel_m = 0) const;

 private:
  Ray to_body(const Ray& ray_W, std::size_t i) const;
  Hit meets_table(const Ray& ray_W, double t_min, double t_max) const;

  struct Placed {
    int index;
    Pose X_BW;      // world to body
    double shrink;  // world's lengths to the body's
    BoundingBall ball_W;
  };
  const RayCaster* caster_;
  std::vector<Placed> placed_;
  BoundingBall all_W_;  // around them all
};

}  // namespace evograsp::sim

// A triangle mesh that rays can meet, with the same bits everywhere.
//
// Embree's own triangle intersection leans on the processor's reciprocal approximations, whose bits differ
// between vendors. So its triangles are user geometry: Embree walks its tree over bounds widened by
// kCullingMargin and only decides which triangles are worth a look; our exact test decides what is hit. The
// nearest hit, the lower index on equal depth, does not depend on the order in which candidates come.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "sim/camera.h"
#include "sim/solid.h"

namespace evograsp::sim {

// Covers Embree's single-precision view of a ray: coordinates up to 10 m round by less than 1e-6 m.
inline constexpr double kCullingMargin = 1e-5;

// Immutable and thread-safe.
class TriangleMesh {
 public:
  // Errors: empty, indices out of range, vertices that are not finite or farther than 10 m from the origin.
  static Result<std::shared_ptr<const TriangleMesh>> create(const proto::TriangleMesh& mesh);
  ~TriangleMesh();
  TriangleMesh(const TriangleMesh&) = delete;
  TriangleMesh& operator=(const TriangleMesh&) = delete;

  // Index of the triangle met first in (t_min, *t), or -1; *t becomes its depth. Both sides are met.
  int enter(const Ray& ray, double t_min, double* t) const;
  // The same by looking at every triangle: the tests' oracle.
  int enter_by_scan(const Ray& ray, double t_min, double* t) const;

  std::size_t size() const { return faces_.size(); }
  Vec3 normal(int triangle) const;  // unit, by the right-hand rule
  const Vec3& corner(int triangle, int k) const {
    return faces_[static_cast<std::size_t>(triangle)].corner[k];
  }
  const BoundingBall& ball() const { return ball_; }

 private:
  TriangleMesh() = default;
  Status build_culling();
  bool meets(std::size_t triangle, const Ray& ray, double t_min, double* t) const;

  struct Culling;  // the Embree scene
  struct Query;
  struct Face {
    Vec3 corner[3];
    Vec3 normal;  // edge cross product, not normalised
  };
  std::vector<Face> faces_;
  BoundingBall ball_;
  std::unique_ptr<Culling> culling_;
};

}  // namespace evograsp::sim

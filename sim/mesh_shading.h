// Normals that make a mesh of flat triangles look round where it is meant to be round.
#pragma once

#include <vector>

#include "sim/triangle_mesh.h"

namespace evograsp::sim {

// For pictures only: what a ray hits is decided by the flat triangles. Immutable and thread-safe.
class MeshShading {
 public:
  // Corners take the mean normal, weighted by area, of the triangles that share their point and whose normals
  // differ by less than about 40 degrees: edges stay sharp.
  explicit MeshShading(const TriangleMesh& mesh);
  // Unit normal at a point of a triangle, blended between its corners; same side as the triangle's own.
  Vec3 normal(const TriangleMesh& mesh, int triangle, const Vec3& p) const;

 private:
  std::vector<Vec3> corner_;  // three a triangle, unit
};

}  // namespace evograsp::sim

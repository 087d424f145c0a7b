// Triangle meshes: cleaning, closedness, orientation, mass properties.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "assets/solid.h"
#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"

namespace evograsp::assets {

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  Vec3 corner(std::size_t triangle, int k) const { return vertices[triangles[triangle][k]]; }
};

// Merges vertices that lie within `tolerance` of a grid point of that spacing (so: at most 2 tolerances
// apart), drops triangles that lose a corner or have no area, twins of the same triangle, and vertices
// without a triangle. O(n log n); the order of what is left is kept.
void weld(Mesh& mesh, double tolerance);

// Turns triangles so that neighbours agree where they can (edges shared by exactly two), then every shell
// outward: a shell that encloses negative volume is turned unless it lies within another (a cavity).
void orient_outward(Mesh& mesh);

// Edges whose two directions are not used equally often. 0: closed, and volume integrals are exact.
std::size_t open_edges(const Mesh& mesh);

// Volume, centre and inertia by the divergence theorem (Eberly, "Polyhedral Mass Properties (Revisited)",
// 2009). Exact for a closed mesh, meaningless for an open one.
Solid solid_of(const Mesh& mesh);
double area_of(const Mesh& mesh);

struct Bounds {
  Vec3 low, high;
  Vec3 extent() const { return high - low; }
};
Bounds bounds_of(const Mesh& mesh);

proto::TriangleMesh visual_of(const Mesh& mesh);
// A mesh as bytes that depend on its content alone, and back. decode checks every count and index.
std::string encode(const Mesh& mesh);
Result<Mesh> decode(std::string_view bytes);

}  // namespace evograsp::assets

// The faces of a convex hull, by qhull (Barber, Dobkin, Huhdanpaa, ACM TOMS 22, 1996).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"

namespace evograsp::sim {

struct HullFaces {
  struct Plane {
    Vec3 normal;  // unit, outwards
    double offset = 0;
  };
  std::vector<Vec3> vertices;  // as given
  std::vector<Plane> planes;   // one a face, coplanar triangles merged
  std::vector<std::array<std::uint32_t, 3>>
      triangles;  // indices into vertices, counter-clockwise from outside
};

inline constexpr int kMaxHullVertices = 4096;

// Errors: fewer than 4 or more than kMaxHullVertices vertices, not finite or beyond 10 m, no volume.
// Thread-safe. The same input gives the same faces in the same order.
Result<HullFaces> hull_faces(const proto::ConvexPart::Hull& hull);

}  // namespace evograsp::sim

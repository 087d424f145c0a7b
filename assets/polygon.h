// Polygons into triangles.
#pragma once

#include <cstdint>
#include <span>

#include "assets/mesh.h"

namespace evograsp::assets {

inline constexpr std::size_t kMaxCorners = 1000;  // of a polygon: cutting takes the third power of it

// Appends the triangles of a polygon, given by its corners in mesh.vertices: 3 to kMaxCorners of them, about
// in a plane, concave ones too (Meisters, "Polygons have ears", 1975). Always corners - 2 triangles that turn
// as the polygon does; one that crosses itself gives triangles of no particular shape.
void add_polygon(std::span<const std::uint32_t> corners, Mesh& mesh);

}  // namespace evograsp::assets

// PLY files (Turk, "The PLY polygon file format", 1994): ASCII, binary little and big endian. A reader of our
// own: assimp's crashes on cut files, and on whole ones whose first binary byte happens to be a line feed.
#pragma once

#include <string_view>

#include "assets/mesh.h"
#include "common/result.h"

namespace evograsp::assets {

// The vertices (properties x, y, z of element vertex, of any type) and the polygons (list vertex_indices or
// vertex_index of element face) of a file, in its units, polygons cut into triangles by their ears. Other
// elements and properties are read over. Work and memory are bounded by the size of the file. Errors say what
// is wrong: header, cut short (announced and found counts), not a number, no such vertex, more than
// kMaxMeshVertices or kMaxMeshTriangles (assets/mesh_import.h). Vertices may be not finite: that is for the
// caller to refuse.
Result<Mesh> read_ply(std::string_view bytes);

}  // namespace evograsp::assets

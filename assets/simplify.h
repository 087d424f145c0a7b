// Fewer triangles for the same shape.
#pragma once

#include "assets/mesh.h"
#include "common/result.h"

namespace evograsp::assets {

// Collapses edges in order of the quadric error they cause (Garland and Heckbert, "Surface simplification
// using quadric error metrics", SIGGRAPH 1997, sections 3 to 5) until max_triangles are left or no edge can
// go without turning a triangle over or pinching the surface. Open borders are held by planes along them.
// Ties go to the lower vertex numbers: one mesh always gives one result. O(n log n), and
// the square of the triangles at one vertex.
Mesh simplified(const Mesh& mesh, std::size_t max_triangles);
// The same in a process of its own: an error that names no file for a mesh that takes too long, since
// thousands of triangles share its vertices or edges. `seconds`: of CPU; 0: by the size of the mesh.
Result<Mesh> contained_simplified(const Mesh& mesh, std::size_t max_triangles, double seconds = 0);

}  // namespace evograsp::assets

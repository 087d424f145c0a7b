// A mesh as an object's shape.
#pragma once

#include <filesystem>
#include <string>

#include "assets/mesh.h"
#include "assets/shape.h"

namespace evograsp::assets {

// Where the centre of mass goes: under or over the origin, or, of what may rest on any face, to the origin.
enum class Centring { kSideways, kWholly };

// Parts by decomposition, the mesh itself (at most 20,000 triangles) as visual, its solid from the closed
// surface or else from the convex hull (a warning): where the surface is open, or crosses itself so that what
// it encloses can be no body. name serves messages. An error: a flat mesh.
Result<Shape> mesh_shape(Mesh mesh, const std::string& name, const proto::Decomposition& settings,
                         const std::filesystem::path& cache, Centring centring);

}  // namespace evograsp::assets

// Concave meshes as few convex parts that keep their hollows.
#pragma once

#include <filesystem>
#include <vector>

#include "assets/mesh.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "proto/object.pb.h"

namespace evograsp::assets {

// Parts of the mesh, at most settings.max_parts. A mesh without a hollow deeper than settings.concavity is
// its hull. Else HACD (Mamou and Ghorbel, "A simple and efficient approach for 3D mesh approximate convex
// decomposition", ICIP 2009) cuts the simplified surface, in a process of its own, and clusters are merged
// again while they swallow no hollow. `cache` keeps parts by the hash of mesh and settings; a damaged entry
// is ignored and written anew, a folder that cannot be written is no error.
Result<std::vector<proto::ConvexPart>> decompose(const Mesh& mesh, const proto::Decomposition& settings,
                                                 const std::filesystem::path& cache);

}  // namespace evograsp::assets

// Clusters of a surface, cut until their hulls swallow no hollow and joined into few again.
#pragma once

#include <cstdint>
#include <vector>

#include "assets/hull.h"
#include "assets/mesh.h"

namespace evograsp::assets {

using TriangleSet = std::vector<std::uint32_t>;  // indices into a mesh's triangles

// Cuts sets whose hull swallows points of `hollow` in two at the median along the axis that leaves least
// swallowed, again and again, up to kMaxClusters. Returns the corners of each set.
inline constexpr std::size_t kMaxClusters = 256;
std::vector<std::vector<Vec3>> split_clusters(const Mesh& mesh, std::vector<TriangleSet> sets,
                                              const std::vector<Vec3>& hollow);

// Merges clusters pair by pair, always the pair whose common hull swallows fewest points of `hollow` that
// neither swallowed before (of equals the one that adds least volume), until any further pair would swallow
// one and at most max_parts are left. Returns the hull vertices of each cluster left. O(n^2) hulls.
std::vector<std::vector<Vec3>> merged_clusters(const std::vector<std::vector<Vec3>>& clusters,
                                               const std::vector<Vec3>& hollow, std::size_t max_parts);

}  // namespace evograsp::assets

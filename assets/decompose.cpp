#include "assets/decompose.h"

#include <HACD/hacdHACD.h>

#include <algorithm>
#include <cstring>

#include "assets/clusters.h"
#include "assets/contained.h"
#include "assets/hollow.h"
#include "assets/hull.h"
#include "assets/part_cache.h"
#include "assets/parts.h"
#include "assets/simplify.h"
#include "common/digest.h"

namespace evograsp::assets {
namespace {

constexpr int kAlgorithm = 1;  // bump when other parts come out of the same input
constexpr double kHacdScale = 1000;
constexpr double kHacdSeconds = 120;
constexpr std::size_t kHollowPoints = 16000;

// Cluster of each triangle.
std::vector<std::uint32_t> hacd_partition(const Mesh& mesh, std::size_t min_parts, double concavity) {
  std::vector<HACD::Vec3<HACD::Real>> points;
  std::vector<HACD::Vec3<long>> triangles;
  for (const Vec3& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  const double diagonal = bounds_of(mesh).extent().norm();
  HACD::HACD hacd;
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetCompacityWeight(0.1);
  hacd.SetVolumeWeight(0);
  hacd.SetNClusters(min_parts);
  hacd.SetNVerticesPerCH(64);
  hacd.SetConcavity(concavity * kHacdScale / diagonal);
  // Without these three HACD fills cups and handles: it sees only each patch's own side of a wall.
  hacd.SetAddExtraDistPoints(true);
  hacd.SetAddNeighboursDistPoints(true);
  hacd.SetAddFacesPoints(true);
  hacd.SetConnectDist(30);
  hacd.Compute();
  const long* partition = hacd.GetPartition();
  return {partition, partition + mesh.triangles.size()};
}

std::vector<TriangleSet> sets_of(const std::vector<std::uint32_t>& partition) {
  std::vector<TriangleSet> sets;
  for (std::uint32_t t = 0; t < partition.size(); ++t) {
    if (partition[t] >= sets.size()) sets.resize(partition[t] + std::size_t{1});
    sets[partition[t]].push_back(t);
  }
  std::erase_if(sets, [](const TriangleSet& set) { return set.empty(); });
  return sets;
}

Result<std::vector<std::uint32_t>> contained_partition(const Mesh& mesh, std::size_t min_parts,
                                                       double concavity) {
  Containment limits;
  limits.seconds = kHacdSeconds;
  const Result<std::string> bytes = run_contained(
      [&]() -> Result<std::string> {
        const std::vector<std::uint32_t> partition = hacd_partition(mesh, min_parts, concavity);
        return std::string(reinterpret_cast<const char*>(partition.data()),
                           partition.size() * sizeof(std::uint32_t));
      },
      limits);
  if (!bytes) return fail(bytes.error().code, "convex decomposition " + bytes.error().message);
  std::vector<std::uint32_t> partition(mesh.triangles.size());
  if (bytes->size() != partition.size() * sizeof(std::uint32_t)) {
    return fail(ErrorCode::kInternal, "convex decomposition gave no partition");
  }
  std::memcpy(partition.data(), bytes->data(), bytes->size());
  for (const std::uint32_t c : partition) {
    if (c >= mesh.triangles.size())
      return fail(ErrorCode::kInternal, "convex decomposition gave a wild partition");
  }
  return partition;
}

std::string cache_key(const Mesh& mesh, const proto::Decomposition& settings) {
  return sha256_hex(std::to_string(kAlgorithm) + "/" + std::to_string(settings.min_parts()) + "/" +
                    std::to_string(settings.concavity()) + "/" +
                    std::to_string(settings.vertices_per_part()) + "/" +
                    std::to_string(settings.max_triangles()) + "/" + std::to_string(settings.max_parts()) +
                    "/" + encode(mesh));
}

Result<std::vector<proto::ConvexPart>> compute(const Mesh& mesh, const proto::Decomposition& settings) {
  const ConvexHull hull = convex_hull(mesh.vertices);
  const std::size_t per_part = settings.vertices_per_part();
  const Mesh coarse = simplified(mesh, settings.max_triangles());
  const std::vector<Vec3> hollow = hollow_points(coarse, hull, settings.concavity(), kHollowPoints);
  if (hollow.empty() && settings.min_parts() <= 1) {
    return std::vector{part_from_points(hull.vertices, 2 * per_part, kRounding)};
  }
  const auto partition = contained_partition(coarse, settings.min_parts(), settings.concavity());
  if (!partition) return tl::unexpected(partition.error());
  const std::size_t max_parts = std::max(settings.min_parts(), settings.max_parts());
  std::vector<proto::ConvexPart> parts;
  const auto clusters = split_clusters(coarse, sets_of(*partition), hollow);
  for (const auto& points : merged_clusters(clusters, hollow, max_parts)) {
    parts.push_back(part_from_points(points, per_part, kRounding));
  }
  return parts;
}

}  // namespace

Result<std::vector<proto::ConvexPart>> decompose(const Mesh& mesh, const proto::Decomposition& settings,
                                                 const std::filesystem::path& cache) {
  const std::string key = cache_key(mesh, settings);
  if (auto parts = cached_parts(cache, key)) return std::move(*parts);
  Result<std::vector<proto::ConvexPart>> parts = compute(mesh, settings);
  if (parts) store_parts(cache, key, *parts);
  return parts;
}

}  // namespace evograsp::assets

#include "assets/decompose.h"

#include <HACD/hacdHACD.h>

#include <algorithm>

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

constexpr int kAlgorithm = 2;  // bump when other parts come out of the same input
constexpr double kHacdScale = 1000;
constexpr double kSeconds = 180;  // of CPU
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

std::string cache_key(const Mesh& mesh, const proto::Decomposition& settings) {
  return sha256_hex(std::to_string(kAlgorithm) + "/" + std::to_string(settings.min_parts()) + "/" +
                    std::to_string(settings.concavity()) + "/" +
                    std::to_string(settings.vertices_per_part()) + "/" +
                    std::to_string(settings.max_triangles()) + "/" + std::to_string(settings.max_parts()) +
                    "/" + encode(mesh));
}

std::vector<proto::ConvexPart> cut_up(const Mesh& coarse, const proto::Decomposition& settings,
                                      const std::vector<Vec3>& hollow) {
  const auto partition = hacd_partition(coarse, settings.min_parts(), settings.concavity());
  const std::size_t max_parts = std::max(settings.min_parts(), settings.max_parts());
  std::vector<proto::ConvexPart> parts;
  const auto clusters = split_clusters(coarse, sets_of(partition), hollow);
  for (const auto& points : merged_clusters(clusters, hollow, max_parts))
    parts.push_back(part_from_points(points, settings.vertices_per_part(), kRounding));
  return parts;
}

std::vector<proto::ConvexPart> compute(const Mesh& mesh, const Mesh& coarse,
                                       const proto::Decomposition& settings) {
  const ConvexHull hull = convex_hull(mesh.vertices);
  const std::vector<Vec3> hollow = hollow_points(coarse, hull, settings.concavity(), kHollowPoints);
  if (!hollow.empty() || settings.min_parts() > 1) return cut_up(coarse, settings, hollow);
  return {part_from_points(hull.vertices, 2 * std::size_t{settings.vertices_per_part()}, kRounding)};
}

// Every step can take for ever on a surface that is none: in a process of its own.
Result<std::vector<proto::ConvexPart>> contained(const Mesh& mesh, const proto::Decomposition& settings) {
  const Result<Mesh> coarse = contained_simplified(mesh, settings.max_triangles());
  if (!coarse) return tl::unexpected(coarse.error());
  Containment limits;
  limits.seconds = kSeconds;
  const Result<std::string> bytes = run_contained(
      [&]() -> Result<std::string> {
        proto::ObjectBundle parts;
        for (proto::ConvexPart& part : compute(mesh, *coarse, settings)) *parts.add_part() = std::move(part);
        return parts.SerializeAsString();
      },
      limits);
  if (!bytes) return fail(bytes.error().code, "convex decomposition " + bytes.error().message);
  proto::ObjectBundle parts;
  if (!parts.ParseFromString(*bytes) || parts.part_size() == 0)
    return fail(ErrorCode::kInternal, "convex decomposition gave no parts");
  return std::vector<proto::ConvexPart>(parts.part().begin(), parts.part().end());
}

}  // namespace

Result<std::vector<proto::ConvexPart>> decompose(const Mesh& mesh, const proto::Decomposition& settings,
                                                 const std::filesystem::path& cache) {
  const std::string key = cache_key(mesh, settings);
  if (auto parts = cached_parts(cache, key)) return std::move(*parts);
  Result<std::vector<proto::ConvexPart>> parts = contained(mesh, settings);
  if (parts) store_parts(cache, key, *parts);
  return parts;
}

}  // namespace evograsp::assets

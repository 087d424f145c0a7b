// A mesh of any vertices and triangles, as import has cleaned it, on its way to a shape: its hull, the parts
// of clusters that the input names, or all of mesh_shape(), whose work is done, unseen by the search, in
// processes of its own.
#include <array>
#include <cmath>
#include <cstring>

#include "assets/clusters.h"
#include "assets/hollow.h"
#include "assets/hull.h"
#include "assets/mesh_import.h"
#include "assets/mesh_shape.h"
#include "assets/parts.h"
#include "assets/simplify.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace evograsp;

constexpr std::size_t kMostVertices = 64, kMostTriangles = 128;

// Coordinates of 0.1 mm, or any single-precision numbers.
assets::Mesh cut_mesh(fuzz::Pieces& pieces, bool any_numbers) {
  assets::Mesh mesh;
  const std::size_t vertices = 3 + pieces.byte() % (kMostVertices - 2);
  for (std::size_t i = 0; i < vertices; ++i) {
    Vec3 v;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t low = pieces.number();
      const std::uint32_t bits = any_numbers ? low | pieces.number() << 16 : low;
      float number = 0;
      std::memcpy(&number, &bits, sizeof number);
      v[k] = any_numbers ? static_cast<double>(number) : static_cast<std::int16_t>(low) * 1e-4;
    }
    mesh.vertices.push_back(v);
  }
  for (std::size_t left = pieces.byte() % (kMostTriangles + 1); left > 0 && !pieces.empty(); --left) {
    std::array<std::uint32_t, 3> t{};
    for (std::uint32_t& v : t) v = pieces.byte() % static_cast<std::uint32_t>(vertices);
    mesh.triangles.push_back(t);
  }
  return mesh;
}

// As import does with what a file held; false: refused there.
bool cleaned(assets::Mesh& mesh) {
  for (const Vec3& v : mesh.vertices)
    if (!is_finite(v)) return false;
  assets::weld(mesh, 1e-7);
  if (mesh.triangles.empty()) return false;
  const double size = assets::bounds_of(mesh).extent().maxCoeff();
  if (!(size >= assets::kMinMeshSize && size <= assets::kMaxMeshSize)) return false;
  assets::orient_outward(mesh);
  return true;
}

using Points = std::vector<Vec3>;

double reach(const Points& points, const Vec3& d) {
  double most = -HUGE_VAL;
  for (const Vec3& p : points) most = std::max(most, d.dot(p));
  return most;
}

void check_corners(const proto::ConvexPart& part, std::size_t most) {
  const auto& xyz = part.hull().xyz();
  fuzz::require(part.has_hull() && xyz.size() >= 3 && xyz.size() % 3 == 0, "a part is a hull");
  fuzz::require(static_cast<std::size_t>(xyz.size()) <= 3 * most, "of no more corners than allowed");
  for (const double x : xyz) fuzz::require(std::isfinite(x), "that are finite");
  fuzz::require(part.rounding() > 0 && part.rounding() <= assets::kRounding, "rounded a little");
}

void check_part(const Points& points, std::size_t most_corners) {
  const proto::ConvexPart part = assets::part_from_points(points, most_corners, assets::kRounding);
  check_corners(part, most_corners);
  const double slack = 4 * part.rounding() + 1e-9;
  for (int i = 0; i < 27; ++i) {
    if (i == 13) continue;
    const int x = i % 3 - 1, y = i / 3 % 3 - 1, z = i / 9 - 1;
    const Vec3 d = Vec3(x, y, z).normalized();
    fuzz::require(assets::support(part, d) <= reach(points, d) + slack, "and hardly beyond its points");
  }
}

void check_hull(const assets::ConvexHull& hull, const assets::Mesh& mesh) {
  for (const auto& face : hull.faces) {
    fuzz::require(face.normal == Vec3::Zero() || std::abs(face.normal.norm() - 1) < 1e-9,
                  "normals are of length 1");
    for (const int v : face.loop)
      fuzz::require(v >= 0 && static_cast<std::size_t>(v) < hull.vertices.size(), "faces name corners");
  }
  const double size = assets::bounds_of(mesh).extent().norm();
  fuzz::require(std::isfinite(hull.area) && hull.width >= 0 && hull.width <= size, "hulls have measures");
  for (const Vec3& v : mesh.vertices) fuzz::require(hull.distance(v) <= 2e-4 * size, "and nothing outside");
}

// As decompose() does between two libraries, with clusters as the input has them instead of HACD's.
void check_clusters(fuzz::Pieces& pieces, const assets::Mesh& mesh, const assets::ConvexHull& hull,
                    const proto::Decomposition& settings) {
  const assets::Mesh coarse = assets::simplified(mesh, 4 + pieces.byte());
  if (coarse.triangles.empty()) return;
  const Points hollow = assets::hollow_points(coarse, hull, settings.concavity(), 500);
  std::vector<assets::TriangleSet> sets(1 + pieces.byte() % 4);
  for (std::uint32_t t = 0; t < coarse.triangles.size(); ++t) sets[pieces.byte() % sets.size()].push_back(t);
  std::erase_if(sets, [](const auto& set) { return set.empty(); });
  const auto clusters = assets::split_clusters(coarse, sets, hollow);
  fuzz::require(clusters.size() <= std::max(assets::kMaxClusters, sets.size()), "clusters are bounded");
  const auto merged = assets::merged_clusters(clusters, hollow, settings.max_parts());
  fuzz::require(!merged.empty() && merged.size() <= settings.max_parts(), "as many parts as were allowed");
  for (const Points& points : merged) check_part(points, settings.vertices_per_part());
}

void check_shape(const assets::Mesh& mesh, const proto::Decomposition& settings) {
  const auto shape = assets::mesh_shape(mesh, "m", settings, {}, assets::Centring::kSideways);
  if (!shape) return fuzz::require(shape.error().message.starts_with("m: "), "a refusal names the file");
  const std::size_t most = std::max(settings.min_parts(), settings.max_parts());
  fuzz::require(!shape->parts.empty() && shape->parts.size() <= most, "as many parts as were allowed");
  for (const auto& part : shape->parts)
    check_corners(part, std::size_t{shape->parts.size() == 1 ? 2U : 1U} * settings.vertices_per_part());
  const assets::Bounds box = assets::bounds_of(mesh);
  fuzz::require(shape->solid.is_body(), "a shape is a body");
  fuzz::require(shape->solid.volume <= 1.01 * box.extent().prod(), "that fits its box");
  fuzz::require(std::abs(shape->solid.centre.x()) < 1e-12 && std::abs(shape->solid.centre.y()) < 1e-12 &&
                    shape->solid.centre.z() >= box.low.z() && shape->solid.centre.z() <= box.high.z(),
                "with its middle within");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Pieces pieces(data, size);
  const std::uint8_t kind = pieces.byte();
  proto::Decomposition settings;
  settings.set_min_parts(1 + pieces.byte() % 8);
  settings.set_max_parts(1 + pieces.byte() % 16);
  settings.set_vertices_per_part(4 + pieces.byte() % 61);
  settings.set_concavity(pieces.byte() * 1e-4);
  settings.set_max_triangles(100);
  assets::Mesh mesh = cut_mesh(pieces, (kind & 1) != 0);
  if (!cleaned(mesh)) return 0;
  const assets::ConvexHull hull = assets::convex_hull(mesh.vertices);
  check_hull(hull, mesh);
  check_part(mesh.vertices, settings.vertices_per_part());
  if (kind % 32 < 2)
    check_shape(mesh, settings);
  else
    check_clusters(pieces, mesh, hull, settings);
  return 0;
}

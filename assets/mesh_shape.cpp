#include "assets/mesh_shape.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "assets/decompose.h"
#include "assets/hull.h"
#include "assets/simplify.h"

namespace evograsp::assets {
namespace {

constexpr std::size_t kVisualTriangles = 20'000;

// Whether a body within that hull can be so. What a surface that crosses itself encloses counts twice in
// places, and in others less than nothing.
bool fits(const Solid& solid, const ConvexHull& hull) {
  constexpr double kSlack = 1.01;  // the hull is computed on a grid
  double reach = 0;
  for (const Vec3& v : hull.vertices) reach = std::max(reach, (v - solid.centre).squaredNorm());
  return solid.is_body() && solid.volume <= kSlack * hull.solid.volume && hull.distance(solid.centre) <= 0 &&
         solid.inertia.trace() / 2 <= kSlack * reach * solid.volume;
}

// Volume, centre and inertia: the mesh's own where it is closed, else its hull's with a warning.
Result<Solid> solid_for(const Mesh& mesh, const std::string& name, std::vector<std::string>& warnings) {
  const ConvexHull hull = convex_hull(mesh.vertices);
  if (!(hull.solid.volume > 1e-12) || !hull.solid.is_body())
    return fail(ErrorCode::kInvalid, name + ": flat, it encloses no volume");
  const std::size_t open = open_edges(mesh);
  if (open > 0) {
    warnings.push_back("not closed (" + std::to_string(open) +
                       " open edges): volume, centre of mass and inertia are those of its convex hull");
    return hull.solid;
  }
  const Solid solid = solid_of(mesh);
  if (solid.volume < 1e-3 * hull.solid.volume) {
    warnings.push_back("encloses next to no volume: centre of mass and inertia are those of its convex hull");
    return hull.solid;
  }
  if (!fits(solid, hull)) {
    warnings.push_back(
        "crosses or overlaps itself: volume, centre of mass and inertia are those of its convex hull");
    return hull.solid;
  }
  return solid;
}

}  // namespace

Result<Shape> mesh_shape(Mesh mesh, const std::string& name, const proto::Decomposition& settings,
                         const std::filesystem::path& cache, Centring centring) {
  Shape shape;
  const Result<Solid> solid = solid_for(mesh, name, shape.warnings);
  if (!solid) return tl::unexpected(solid.error());
  shape.solid = *solid;
  Vec3 aside = shape.solid.centre;
  if (centring == Centring::kSideways) aside.z() = 0;
  for (Vec3& v : mesh.vertices) v -= aside;
  shape.solid.centre -= aside;
  Result<std::vector<proto::ConvexPart>> parts = decompose(mesh, settings, cache);
  if (!parts) return fail(parts.error().code, name + ": " + parts.error().message);
  shape.parts = std::move(*parts);
  const Result<Mesh> visual = contained_simplified(mesh, kVisualTriangles);
  if (!visual) return fail(visual.error().code, name + ": " + visual.error().message);
  shape.visual = visual_of(*visual);
  return shape;
}

}  // namespace evograsp::assets

#include "sim/mesh_shading.h"

#include <algorithm>
#include <array>
#include <map>

namespace evograsp::sim {
namespace {

constexpr double kSharp = 0.77;  // cosine of the crease angle

using Key = std::array<double, 3>;
Key key_of(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

}  // namespace

MeshShading::MeshShading(const TriangleMesh& mesh) {
  std::map<Key, std::vector<int>> sharing;
  const int count = static_cast<int>(mesh.size());
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k) sharing[key_of(mesh.corner(i, k))].push_back(i);
  corner_.reserve(3 * mesh.size());
  for (int i = 0; i < count; ++i) {
    const Vec3 own = mesh.normal(i);
    for (int k = 0; k < 3; ++k) {
      Vec3 sum = Vec3::Zero();
      for (const int j : sharing[key_of(mesh.corner(i, k))]) {
        const Vec3 area =
            (mesh.corner(j, 1) - mesh.corner(j, 0)).cross(mesh.corner(j, 2) - mesh.corner(j, 0));
        if (mesh.normal(j).dot(own) > kSharp) sum += area;
      }
      corner_.push_back(sum.norm() > 0 ? Vec3(sum.normalized()) : own);
    }
  }
}

Vec3 MeshShading::normal(const TriangleMesh& mesh, int triangle, const Vec3& p) const {
  const Vec3 &a = mesh.corner(triangle, 0), &b = mesh.corner(triangle, 1), &c = mesh.corner(triangle, 2);
  const Vec3 n = (b - a).cross(c - a);
  const double size = n.dot(n);
  if (!(size > 0)) return mesh.normal(triangle);
  const double u = std::clamp((b - p).cross(c - p).dot(n) / size, 0.0, 1.0);
  const double v = std::clamp((c - p).cross(a - p).dot(n) / size, 0.0, 1.0);
  const std::size_t first = 3 * static_cast<std::size_t>(triangle);
  const Vec3 mean =
      u * corner_[first] + v * corner_[first + 1] + std::max(0.0, 1 - u - v) * corner_[first + 2];
  return mean.norm() > 0 ? Vec3(mean.normalized()) : mesh.normal(triangle);
}

}  // namespace evograsp::sim

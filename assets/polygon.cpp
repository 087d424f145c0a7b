#include "assets/polygon.h"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

namespace evograsp::assets {
namespace {

using Vec2 = Eigen::Vector2d;

struct Corner {
  std::uint32_t vertex;
  Vec2 at;
};

// Newell's normal: the sum of the polygon's signed areas along each axis.
Vec3 normal_of(std::span<const std::uint32_t> corners, const Mesh& mesh) {
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i)
    normal += mesh.vertices[corners[i]].cross(mesh.vertices[corners[(i + 1) % corners.size()]]);
  return normal;
}

// Along the axis on which the polygon is largest, turned to run counterclockwise.
std::vector<Corner> projected(std::span<const std::uint32_t> corners, const Mesh& mesh) {
  const Vec3 normal = normal_of(corners, mesh);
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<Corner> out;
  for (const std::uint32_t c : corners) {
    const Vec3& p = mesh.vertices[c];
    out.push_back({c, Vec2(p[u], normal[axis] < 0 ? -p[v] : p[v])});
  }
  return out;
}

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool is_ear(const std::vector<Corner>& ring, std::size_t i) {
  const std::size_t n = ring.size();
  const Vec2 &a = ring[(i + n - 1) % n].at, &b = ring[i].at, &c = ring[(i + 1) % n].at;
  if (!(turn(a, b, c) > 0)) return false;
  for (const Corner& other : ring) {
    const Vec2& p = other.at;
    if (p == a || p == b || p == c) continue;
    if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

void add_polygon(std::span<const std::uint32_t> corners, Mesh& mesh) {
  if (corners.size() == 3) {
    mesh.triangles.push_back({corners[0], corners[1], corners[2]});
    return;
  }
  std::vector<Corner> ring = projected(corners, mesh);
  while (ring.size() >= 3) {
    const std::size_t n = ring.size();
    std::size_t ear = 0;
    while (ear < n && !is_ear(ring, ear)) ++ear;
    if (ear == n) ear = 1 % n;  // no ear where the polygon is flat or crosses itself
    mesh.triangles.push_back({ring[(ear + n - 1) % n].vertex, ring[ear].vertex, ring[(ear + 1) % n].vertex});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
  }
}

}  // namespace evograsp::assets

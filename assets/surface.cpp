#include "assets/surface.h"

#include <Eigen/Geometry>

#include "common/det_math.h"

namespace evograsp::assets {
namespace {

std::uint32_t add_vertex(const Vec3& p, proto::TriangleMesh& mesh) {
  for (int k = 0; k < 3; ++k) mesh.add_xyz(static_cast<float>(p[k]));
  return static_cast<std::uint32_t>(mesh.xyz_size() / 3 - 1);
}

void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, proto::TriangleMesh& mesh) {
  mesh.add_triangle(a);
  mesh.add_triangle(b);
  mesh.add_triangle(c);
}

// A ring of vertices, or one vertex where the ring shrinks to a point.
struct Ring {
  std::uint32_t first;
  bool point;
  std::uint32_t at(int i, int sides) const {
    return point ? first : first + static_cast<std::uint32_t>(i % sides);
  }
};

void join(const Ring& a, const Ring& b, int sides, proto::TriangleMesh& mesh) {
  for (int i = 0; i < sides; ++i) {
    if (!a.point) add_triangle(a.at(i, sides), a.at(i + 1, sides), b.at(i, sides), mesh);
    if (!b.point) add_triangle(a.at(i + 1, sides), b.at(i + 1, sides), b.at(i, sides), mesh);
  }
}

}  // namespace

void add_lathe(std::span<const ProfilePoint> profile, int sides, proto::TriangleMesh& mesh) {
  std::vector<Ring> rings;
  for (const ProfilePoint& p : profile) {
    Ring ring{static_cast<std::uint32_t>(mesh.xyz_size() / 3), p.radius == 0};
    for (int i = 0; i < (ring.point ? 1 : sides); ++i) {
      const double a = 2 * det::kPi * i / sides;
      add_vertex({p.radius * det::cos(a), p.radius * det::sin(a), p.z}, mesh);
    }
    rings.push_back(ring);
  }
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) join(rings[i], rings[i + 1], sides, mesh);
}

void add_tube(std::span<const Vec3> path, double radius, int sides, proto::TriangleMesh& mesh) {
  const int n = static_cast<int>(path.size());
  std::vector<Ring> rings{{add_vertex(path[0], mesh), true}};
  for (int i = 0; i < n; ++i) {
    const Vec3 ahead = path[std::min(i + 1, n - 1)] - path[std::max(i - 1, 0)];
    const Vec3 t = ahead / ahead.norm();
    const Vec3 across = t.cross(Vec3::UnitY());
    Ring ring{static_cast<std::uint32_t>(mesh.xyz_size() / 3), false};
    for (int j = 0; j < sides; ++j) {
      const double a = 2 * det::kPi * j / sides;
      add_vertex(path[i] + radius * (det::cos(a) * across + det::sin(a) * Vec3::UnitY()), mesh);
    }
    rings.push_back(ring);
  }
  rings.push_back({add_vertex(path[n - 1], mesh), true});
  // Seen along the path the rings run clockwise: joined backwards, the triangles face out.
  for (std::size_t i = rings.size() - 1; i > 0; --i) join(rings[i], rings[i - 1], sides, mesh);
}

}  // namespace evograsp::assets

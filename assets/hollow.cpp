#include "assets/hollow.h"

#include <algorithm>
#include <cmath>

#include "common/det_math.h"

namespace evograsp::assets {
namespace {

// Signed solid angle of a triangle seen from the origin, over 2 (Van Oosterom and Strackee 1983).
double half_solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return det::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

bool outside(const Mesh& mesh, const Vec3& p) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    sum += half_solid_angle(mesh.corner(t, 0) - p, mesh.corner(t, 1) - p, mesh.corner(t, 2) - p);
  }
  return std::fabs(sum) < det::kPi;  // a full turn is 2 pi here
}

bool near_surface(const Mesh& mesh, const Vec3& p, double depth) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    if (((low - p).array() > depth).any() || ((p - high).array() > depth).any()) continue;
    if (distance_to_triangle(p, a, b, c) <= depth) return true;
  }
  return false;
}

struct Grid {
  Vec3 low;
  double spacing;
  int count[3];
};

Grid grid_over(const Bounds& box, std::size_t max_points) {
  const Vec3 extent = box.extent();
  Grid grid{box.low, extent.maxCoeff() / 64, {}};
  while (true) {
    std::size_t points = 1;
    for (int k = 0; k < 3; ++k) {
      grid.count[k] = std::max(1, static_cast<int>(extent[k] / grid.spacing));
      points *= static_cast<std::size_t>(grid.count[k]);
    }
    if (points <= max_points) return grid;
    grid.spacing *= 1.05;
  }
}

}  // namespace

std::vector<Vec3> hollow_points(const Mesh& mesh, const ConvexHull& hull, double depth,
                                std::size_t max_points) {
  if (hull.width == 0) return {};
  const Bounds box = bounds_of(mesh);
  const Grid grid = grid_over(box, max_points);
  std::vector<Vec3> points;
  for (int i = 0; i < grid.count[0]; ++i) {
    for (int j = 0; j < grid.count[1]; ++j) {
      for (int k = 0; k < grid.count[2]; ++k) {
        const Vec3 share((i + 0.5) / grid.count[0], (j + 0.5) / grid.count[1], (k + 0.5) / grid.count[2]);
        const Vec3 p = box.low + share.cwiseProduct(box.extent());
        if (hull.distance(p) < 0 && !near_surface(mesh, p, depth) && outside(mesh, p)) points.push_back(p);
      }
    }
  }
  return points;
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return ap.norm();
  if (d3 >= 0 && d4 <= d3) return bp.norm();
  if (d6 >= 0 && d5 <= d6) return cp.norm();
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).norm();
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).norm();
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).norm();
  const double sum = va + vb + vc;
  return (ap - vb / sum * ab - vc / sum * ac).norm();
}

}  // namespace evograsp::assets

#include "assets/hull.h"

#include <LinearMath/btConvexHullComputer.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "assets/parts.h"

namespace evograsp::assets {
namespace {

constexpr double kGrid = 1e-4;  // Bullet computes the hull on an integer grid this fine, of the extent

// Newell's normal: twice the area vector of the loop.
Vec3 area_vector(const std::vector<Vec3>& vertices, const std::vector<int>& loop) {
  Vec3 sum = Vec3::Zero();
  const Vec3 origin = vertices[loop[0]];
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    sum += (vertices[loop[i]] - origin).cross(vertices[loop[i + 1]] - origin);
  }
  return sum;
}

Vec3 mean_of(const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  return mean / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

double longest_edge(const std::vector<Vec3>& vertices, const std::vector<int>& loop) {
  double longest = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    longest = std::max(longest, (vertices[loop[i]] - vertices[loop[(i + 1) % loop.size()]]).norm());
  }
  return longest;
}

void add_faces(const btConvexHullComputer& computer, const Vec3& inside, ConvexHull& hull) {
  double reach = 0;
  for (const Vec3& v : hull.vertices) reach = std::max(reach, (v - inside).norm());
  const double sliver = 4 * kGrid * reach;  // thinner faces have no dependable normal
  for (int f = 0; f < computer.faces.size(); ++f) {
    const auto* first = &computer.edges[computer.faces[f]];
    ConvexHull::Face face{Vec3::Zero(), 0, {}};
    const auto* edge = first;
    do {
      face.loop.push_back(edge->getTargetVertex());
      edge = edge->getNextEdgeOfFace();
    } while (edge != first);
    const Vec3 twice = area_vector(hull.vertices, face.loop);
    const double length = twice.norm();
    hull.area += length / 2;
    if (length > sliver * longest_edge(hull.vertices, face.loop)) face.normal = twice / length;
    if (face.normal.dot(hull.vertices[face.loop[0]] - inside) < 0) {
      face.normal = -face.normal;
      std::reverse(face.loop.begin(), face.loop.end());
    }
    face.offset = -HUGE_VAL;
    for (const Vec3& v : hull.vertices) face.offset = std::max(face.offset, face.normal.dot(v));
    hull.faces.push_back(std::move(face));
  }
}

void add_solid(const Vec3& inside, ConvexHull& hull) {
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  double volume = 0;
  for (const auto& face : hull.faces) {
    for (std::size_t i = 1; i + 1 < face.loop.size(); ++i) {
      const Vec3 a = hull.vertices[face.loop[0]] - inside, b = hull.vertices[face.loop[i]] - inside,
                 c = hull.vertices[face.loop[i + 1]] - inside;
      const double six = a.dot(b.cross(c));
      const Vec3 sum = a + b + c;
      volume += six / 6;
      first += six / 24 * sum;
      second +=
          six / 120 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
  }
  if (!(volume > 1e-18)) return;
  const Vec3 centre = first / volume;
  const Mat3 moment = second - volume * centre * centre.transpose();
  hull.solid = {volume, inside + centre, moment.trace() * Mat3::Identity() - moment};
}

// Farthest-point sampling: for hulls without volume, where "outside" means nothing.
std::vector<Vec3> spread_points(const std::vector<Vec3>& points, std::size_t count) {
  std::vector<Vec3> chosen;
  const Vec3 mean = mean_of(points);
  std::vector<double> nearest;
  for (const Vec3& p : points) nearest.push_back((p - mean).norm());
  while (chosen.size() < std::min(count, points.size())) {
    const std::size_t i = std::max_element(nearest.begin(), nearest.end()) - nearest.begin();
    if (!chosen.empty() && nearest[i] <= 0) break;
    chosen.push_back(points[i]);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double d = (points[k] - points[i]).norm();
      nearest[k] = chosen.size() == 1 ? d : std::min(nearest[k], d);
    }
  }
  return chosen;
}

// Each vertex moved so that the planes of its faces lie r further in (least squares, at most 3 r far).
std::vector<Vec3> shrunk(const ConvexHull& hull, double r) {
  std::vector<Mat3> normal_matrix(hull.vertices.size(), 1e-6 * Mat3::Identity());
  std::vector<Vec3> target(hull.vertices.size(), Vec3::Zero());
  for (const auto& face : hull.faces) {
    for (const int v : face.loop) {
      normal_matrix[v] += face.normal * face.normal.transpose();
      target[v] -= r * face.normal;
    }
  }
  std::vector<Vec3> out;
  for (std::size_t v = 0; v < hull.vertices.size(); ++v) {
    Vec3 move = normal_matrix[v].inverse() * target[v];
    const double length = move.norm();
    if (length > 3 * r) move *= 3 * r / length;
    out.push_back(hull.vertices[v] + move);
  }
  return out;
}

}  // namespace

double ConvexHull::distance(const Vec3& p) const {
  double most = -HUGE_VAL;
  for (const Face& face : faces) {
    if (face.normal != Vec3::Zero()) most = std::max(most, face.normal.dot(p) - face.offset);
  }
  return most;
}

ConvexHull convex_hull(const std::vector<Vec3>& points) {
  ConvexHull hull;
  if (points.empty()) return hull;
  btConvexHullComputer computer;
  computer.compute(points[0].data(), sizeof(Vec3), static_cast<int>(points.size()), 0, 0);
  for (int i = 0; i < computer.vertices.size(); ++i)
    hull.vertices.push_back(points[computer.original_vertex_index[i]]);
  const Vec3 inside = mean_of(hull.vertices);
  add_faces(computer, inside, hull);
  add_solid(inside, hull);
  hull.width = HUGE_VAL;
  for (const auto& face : hull.faces) {
    double least = HUGE_VAL;
    for (const Vec3& v : hull.vertices) least = std::min(least, face.normal.dot(v));
    if (face.normal != Vec3::Zero()) hull.width = std::min(hull.width, face.offset - least);
  }
  if (hull.width == HUGE_VAL || hull.solid.volume == 0) hull.width = 0;
  return hull;
}

std::vector<Vec3> reduced_hull(const ConvexHull& hull, std::size_t max_vertices, double tolerance) {
  if (hull.vertices.size() <= max_vertices && tolerance <= 0) return hull.vertices;
  if (hull.solid.volume == 0) return spread_points(hull.vertices, max_vertices);
  std::vector<Vec3> chosen = spread_points(hull.vertices, std::min<std::size_t>(6, max_vertices));
  while (chosen.size() < max_vertices) {
    const ConvexHull sketch = convex_hull(chosen);
    double most = tolerance;
    const Vec3* next = nullptr;
    for (const Vec3& v : hull.vertices) {
      const double out = sketch.distance(v);
      if (out > most) most = out, next = &v;
    }
    if (next == nullptr) break;
    chosen.push_back(*next);
  }
  return chosen;
}

proto::ConvexPart part_from_points(const std::vector<Vec3>& points, std::size_t max_vertices,
                                   double rounding) {
  constexpr double kLeast = 5e-5, kTolerance = 3e-4;
  const ConvexHull full = convex_hull(points);
  const ConvexHull hull = convex_hull(reduced_hull(full, max_vertices, kTolerance));
  const double r = std::min(rounding, hull.width / 4);
  if (r < kLeast) {
    const bool on_a_line = hull.vertices.size() < 3;
    return hull_part(on_a_line ? spread_points(points, max_vertices) : hull.vertices,
                     std::min(rounding, kLeast));
  }
  double lost = 0;
  for (const Vec3& v : full.vertices) lost = std::max(lost, hull.distance(v));
  return hull_part(shrunk(hull, std::max(0.0, r - lost / 2)), r);
}

}  // namespace evograsp::assets

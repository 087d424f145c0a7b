#include "assets/clusters.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <tuple>

namespace evograsp::assets {
namespace {

// Hollow points inside a hull, ascending.
std::vector<std::uint32_t> swallowed_by(const ConvexHull& hull, const std::vector<Vec3>& hollow) {
  std::vector<std::uint32_t> inside;
  if (hull.width == 0) return inside;
  Vec3 low = Vec3::Constant(HUGE_VAL), high = Vec3::Constant(-HUGE_VAL);
  for (const Vec3& p : hull.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  for (std::uint32_t i = 0; i < hollow.size(); ++i) {
    const Vec3& p = hollow[i];
    const bool in_box = (p.array() > low.array()).all() && (p.array() < high.array()).all();
    if (in_box && hull.distance(p) < 0) inside.push_back(i);
  }
  return inside;
}

std::vector<Vec3> corners_of(const Mesh& mesh, const TriangleSet& set) {
  std::vector<Vec3> points;
  for (const std::uint32_t t : set) {
    for (int k = 0; k < 3; ++k) points.push_back(mesh.corner(t, k));
  }
  return points;
}

// The two halves of a set at the median of its triangles' middles along an axis.
std::pair<TriangleSet, TriangleSet> halves(const Mesh& mesh, const TriangleSet& set, int axis) {
  const auto middle = [&](std::uint32_t t) {
    return mesh.corner(t, 0)[axis] + mesh.corner(t, 1)[axis] + mesh.corner(t, 2)[axis];
  };
  TriangleSet sorted = set;
  std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(middle(a), a) < std::tuple(middle(b), b);
  });
  const auto half = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  return {{sorted.begin(), half}, {half, sorted.end()}};
}

std::pair<TriangleSet, TriangleSet> best_cut(const Mesh& mesh, const TriangleSet& set,
                                             const std::vector<Vec3>& hollow) {
  std::pair<TriangleSet, TriangleSet> best;
  std::size_t least = SIZE_MAX;
  for (int axis = 0; axis < 3; ++axis) {
    auto cut = halves(mesh, set, axis);
    const std::size_t left = swallowed_by(convex_hull(corners_of(mesh, cut.first)), hollow).size() +
                             swallowed_by(convex_hull(corners_of(mesh, cut.second)), hollow).size();
    if (left < least) least = left, best = std::move(cut);
  }
  return best;
}

struct Cluster {
  ConvexHull hull;
  Vec3 low, high;
  std::vector<std::uint32_t> swallowed;  // hollow points inside, ascending
};

struct Cost {
  std::size_t swallowed = 0;
  bool apart = false;  // boxes do not touch: joined only when nothing else is left
  double volume = HUGE_VAL;
  bool operator<(const Cost& o) const {
    return std::tie(apart, swallowed, volume) < std::tie(o.apart, o.swallowed, o.volume);
  }
};

class Merger {
 public:
  Merger(const std::vector<std::vector<Vec3>>& clusters, const std::vector<Vec3>& hollow) : hollow_(hollow) {
    for (const auto& points : clusters) clusters_.push_back(cluster_of(points));
    costs_.assign(clusters_.size(), std::vector<Cost>(clusters_.size()));
    for (std::size_t i = 0; i < clusters_.size(); ++i) {
      for (std::size_t j = i + 1; j < clusters_.size(); ++j) costs_[i][j] = cost(clusters_[i], clusters_[j]);
    }
  }

  std::vector<std::vector<Vec3>> run(std::size_t max_parts) {
    while (clusters_.size() > 1) {
      const auto [a, b] = cheapest();
      const Cost& cost = costs_[a][b];
      if (clusters_.size() <= max_parts && (cost.swallowed > 0 || cost.apart)) break;
      join(a, b);
    }
    std::vector<std::vector<Vec3>> out;
    for (Cluster& cluster : clusters_) out.push_back(std::move(cluster.hull.vertices));
    return out;
  }

 private:
  Cluster cluster_of(const std::vector<Vec3>& points) const {
    Cluster c{convex_hull(points), Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL), {}};
    for (const Vec3& p : c.hull.vertices) c.low = c.low.cwiseMin(p), c.high = c.high.cwiseMax(p);
    c.swallowed = swallowed_by(c.hull, hollow_);
    return c;
  }

  Cluster joined(const Cluster& a, const Cluster& b) const {
    std::vector<Vec3> points = a.hull.vertices;
    points.insert(points.end(), b.hull.vertices.begin(), b.hull.vertices.end());
    return cluster_of(points);
  }

  Cost cost(const Cluster& a, const Cluster& b) const {
    constexpr double kTouch = 0.001;  // m
    Cost out;
    out.apart = (a.low - b.high).cwiseMax(b.low - a.high).maxCoeff() > kTouch;
    const double volumes = a.hull.solid.volume + b.hull.solid.volume;
    if (out.apart) {  // judged by distance: their hull is not worth computing
      out.volume = ((a.low + a.high) - (b.low + b.high)).norm();
      return out;
    }
    const Cluster both = joined(a, b);
    std::vector<std::uint32_t> before, anew;
    std::set_union(a.swallowed.begin(), a.swallowed.end(), b.swallowed.begin(), b.swallowed.end(),
                   std::back_inserter(before));
    std::set_difference(both.swallowed.begin(), both.swallowed.end(), before.begin(), before.end(),
                        std::back_inserter(anew));
    out.swallowed = anew.size();
    out.volume = both.hull.solid.volume - volumes;
    return out;
  }

  std::pair<std::size_t, std::size_t> cheapest() const {
    std::size_t a = 0, b = 1;
    for (std::size_t i = 0; i < clusters_.size(); ++i) {
      for (std::size_t j = i + 1; j < clusters_.size(); ++j) {
        if (costs_[i][j] < costs_[a][b]) a = i, b = j;
      }
    }
    return {a, b};
  }

  void join(std::size_t a, std::size_t b) {
    const auto at_b = static_cast<std::ptrdiff_t>(b);
    clusters_[a] = joined(clusters_[a], clusters_[b]);
    clusters_.erase(clusters_.begin() + at_b);
    costs_.erase(costs_.begin() + at_b);
    for (auto& row : costs_) row.erase(row.begin() + at_b);
    for (std::size_t i = 0; i < clusters_.size(); ++i) {
      const std::size_t low = std::min(i, a), high = std::max(i, a);
      if (low != high) costs_[low][high] = cost(clusters_[low], clusters_[high]);
    }
  }

  const std::vector<Vec3>& hollow_;
  std::vector<Cluster> clusters_;
  std::vector<std::vector<Cost>> costs_;  // [low][high]
};

}  // namespace

std::vector<std::vector<Vec3>> split_clusters(const Mesh& mesh, std::vector<TriangleSet> sets,
                                              const std::vector<Vec3>& hollow) {
  std::vector<std::vector<Vec3>> done;
  while (!sets.empty()) {
    const TriangleSet set = std::move(sets.back());
    sets.pop_back();
    std::vector<Vec3> points = corners_of(mesh, set);
    const bool may_cut = set.size() > 1 && done.size() + sets.size() + 2 <= kMaxClusters;
    if (!may_cut || swallowed_by(convex_hull(points), hollow).empty()) {
      done.push_back(std::move(points));
      continue;
    }
    auto [low, high] = best_cut(mesh, set, hollow);
    sets.push_back(std::move(low));
    sets.push_back(std::move(high));
  }
  return done;
}

std::vector<std::vector<Vec3>> merged_clusters(const std::vector<std::vector<Vec3>>& clusters,
                                               const std::vector<Vec3>& hollow, std::size_t max_parts) {
  return Merger(clusters, hollow).run(max_parts);
}

}  // namespace evograsp::assets

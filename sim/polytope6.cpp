#include "sim/polytope6.h"

#include <algorithm>

#include "common/random.h"
#include "sim/six.h"

namespace evograsp::sim {
namespace {

using six::dot, six::invert, six::magnitude, six::square_root, six::Tolerance;

constexpr int kMaxFacets = 1 << 18;  // far beyond any real grasp; bounds memory on hostile sets

}  // namespace

template <class Real>
void Polytope6<Real>::load(std::span<const Point> points) {
  count_ = static_cast<int>(points.size());
  points_.assign(points.begin(), points.end());
  columns_.resize(6 * points.size());
  products_.resize(points.size());
  for (int i = 0; i < count_; ++i) {
    for (int x = 0; x < 6; ++x) columns_[x * count_ + i] = points_[i][x];
  }
  for (std::size_t i = names_.size(); i < points.size(); ++i) names_.push_back(mix64(i + 1));
  used_ = 0;
  heap_.clear();
  epoch_ = 0;
}

template <class Real>
typename Polytope6<Real>::Extent Polytope6<Real>::extent(const Point& direction) {
  const Real* c = columns_.data();
  const int n = count_;
  for (int i = 0; i < n; ++i) {
    products_[i] = ((c[i] * direction[0] + c[n + i] * direction[1]) +
                    (c[2 * n + i] * direction[2] + c[3 * n + i] * direction[3])) +
                   (c[4 * n + i] * direction[4] + c[5 * n + i] * direction[5]);
  }
  Extent e{0, 0, products_[0], products_[0]};
  for (int i = 1; i < n; ++i) {
    if (products_[i] > e.most) {
      e.most = products_[i];
      e.high = i;
    } else if (products_[i] < e.least) {
      e.least = products_[i];
      e.low = i;
    }
  }
  return e;
}

// Seven corners, each as far as the set goes perpendicular to the ones before, toward the origin where that
// is a direction. False when the set is thin along one of these directions or has the origin at or beyond its
// border.
template <class Real>
bool Polytope6<Real>::pick_simplex(std::array<int, 7>& corner) {
  const Real thin = Tolerance<Real>::kThin;
  std::array<Point, 6> basis;
  Point base{};
  for (int s = 0; s < 7; ++s) {
    Point u{};
    Real length = 0;
    for (int attempt = -1; attempt < 6 && !(length > 0.05); ++attempt) {
      // First the way back to the origin, then the coordinate axes: one of those keeps 1/sqrt(6) of its
      // length.
      for (int x = 0; x < 6; ++x) u[x] = attempt < 0 ? -base[x] : Real(x == attempt);
      for (int b = 0; b + 1 < s; ++b) {
        const Real along = dot(u, basis[b]);
        for (int x = 0; x < 6; ++x) u[x] -= along * basis[b][x];
      }
      length = square_root(dot(u, u));
    }
    for (int x = 0; x < 6; ++x) u[x] /= length;
    const Extent e = extent(u);
    if (!(e.most > thin) || !(e.least < -thin)) return false;
    radius_ = std::min(radius_, std::min(e.most, -e.least));
    const Real from = s == 0 ? Real(0) : dot(u, base);
    corner[s] = e.most - from >= from - e.least ? e.high : e.low;
    if (s == 0) {
      base = points_[corner[0]];
      continue;
    }
    Point& v = basis[s - 1];
    for (int x = 0; x < 6; ++x) v[x] = points_[corner[s]][x] - base[x];
    for (int pass = 0; pass < 2; ++pass) {
      for (int b = 0; b + 1 < s; ++b) {
        const Real along = dot(v, basis[b]);
        for (int x = 0; x < 6; ++x) v[x] -= along * basis[b][x];
      }
    }
    const Real height = square_root(dot(v, v));
    if (!(height > thin)) return false;
    for (int x = 0; x < 6; ++x) v[x] /= height;
  }
  return true;
}

// The seven facets of the first simplex. With the barycentric coordinates L_i(x) = 1/7 + g_i . (x - c), the
// facet opposite corner o has the normal -7 g_o and the inverse rows g_k - g_o.
template <class Real>
bool Polytope6<Real>::build_simplex(const std::array<int, 7>& corner) {
  centre_ = {};
  for (int c : corner) {
    for (int x = 0; x < 6; ++x) centre_[x] += points_[c][x] / 7;
  }
  std::array<Point, 6> edges;
  for (int k = 0; k < 6; ++k) {
    for (int x = 0; x < 6; ++x) edges[x][k] = points_[corner[k + 1]][x] - points_[corner[0]][x];
  }
  if (!invert(edges)) return false;
  std::array<Point, 7> gradient{};
  for (int k = 0; k < 6; ++k) {
    gradient[k + 1] = edges[k];
    for (int x = 0; x < 6; ++x) gradient[0][x] -= edges[k][x];
  }
  for (int i = 0; i < count_; ++i) {
    for (int x = 0; x < 6; ++x) columns_[x * count_ + i] = points_[i][x] -= centre_[x];
  }
  for (int o = 0; o < 7; ++o) {
    const int id = new_facet();
    Facet& facet = facets_[id];
    for (int i = 0, k = 0; i < 7; ++i) {
      if (i == o) continue;
      facet.vertex[k] = corner[i];
      facet.neighbour[k++] = i;
    }
    for (int x = 0; x < 6; ++x) facet.normal[x] = -7 * gradient[o][x];
    measure(facet);
    push(id);
  }
  return true;
}

template <class Real>
void Polytope6<Real>::measure(Facet& facet) {
  facet.norm = square_root(dot(facet.normal, facet.normal));
  facet.distance = (1 + dot(facet.normal, centre_)) / facet.norm;
}

template <class Real>
int Polytope6<Real>::new_facet() {
  if (used_ == static_cast<int>(facets_.size()))
    facets_.resize(std::max<std::size_t>(1024, 2 * facets_.size()));
  Facet& facet = facets_[used_];
  facet.neighbour.fill(-1);
  facet.mark = 0;
  facet.alive = true;
  return used_++;
}

template <class Real>
void Polytope6<Real>::push(int facet) {
  const Real distance = facets_[facet].distance;
  if (distance > radius_ + Tolerance<Real>::kGap) return;  // the answer is nearer: it will never be looked at
  heap_.push_back({distance, facet});
  std::push_heap(heap_.begin(), heap_.end(), [](const Entry& a, const Entry& b) {
    return a.distance > b.distance || (a.distance == b.distance && a.facet > b.facet);
  });
}

template <class Real>
int Polytope6<Real>::pop() {
  std::pop_heap(heap_.begin(), heap_.end(), [](const Entry& a, const Entry& b) {
    return a.distance > b.distance || (a.distance == b.distance && a.facet > b.facet);
  });
  const int facet = heap_.back().facet;
  heap_.pop_back();
  return facet;
}

template <class Real>
typename Polytope6<Real>::Outcome Polytope6<Real>::expand(std::span<const Point> points) {
  if (points.size() < 7) return Outcome::kOutside;
  load(points);
  radius_ = 4;  // no point is that long; the extents of the set along any direction lower this bound
  std::array<int, 7> corner;
  if (!pick_simplex(corner)) return Outcome::kOutside;
  if (!build_simplex(corner)) return Outcome::kGaveUp;
  const Real gap = Tolerance<Real>::kGap;
  while (!heap_.empty()) {
    const int id = pop();
    const Facet& facet = facets_[id];
    if (!facet.alive) continue;
    const Extent e = extent(facet.normal);
    const Real reach = (e.most + dot(facet.normal, centre_)) / facet.norm;
    if (!(reach > gap)) return Outcome::kOutside;
    if (reach <= radius_ + gap) {
      radius_ = std::min(radius_, reach);
      for (int x = 0; x < 6; ++x) direction_[x] = facet.normal[x] / facet.norm;
    }
    if (radius_ - facet.distance <= gap) return Outcome::kInside;
    const Outcome added = add_point(id, e.high);
    if (added != Outcome::kInside) return added;
  }
  return Outcome::kGaveUp;
}

// The facets that the point sees, reached from one of them, and the ridges where they end.
template <class Real>
void Polytope6<Real>::mark_visible(int seed, const Point& point) {
  const int seen = 2 * ++epoch_, hidden = seen + 1;
  const Real least = Tolerance<Real>::kSeen;
  visible_.assign(1, seed);
  horizon_.clear();
  facets_[seed].mark = seen;
  facets_[seed].height = dot(facets_[seed].normal, point) - 1;
  for (std::size_t at = 0; at < visible_.size(); ++at) {
    const int id = visible_[at];
    for (int k = 0; k < 6; ++k) {
      const int next = facets_[id].neighbour[k];
      Facet& facet = facets_[next];
      if (facet.mark == seen) continue;
      if (facet.mark != hidden) {
        facet.height = dot(facet.normal, point) - 1;
        if (facet.height > least * facet.norm) {
          facet.mark = seen;
          visible_.push_back(next);
          continue;
        }
        facet.mark = hidden;
      }
      horizon_.push_back({id, k});
    }
  }
}

// The facet spanned by the point and the ridge opposite vertex `slot` of a visible facet.
template <class Real>
bool Polytope6<Real>::make_heir(int visible, int slot, int point) {
  const int id = new_facet();
  Facet& heir = facets_[id];
  const Facet& seen = facets_[visible];
  Facet& hidden = facets_[seen.neighbour[slot]];
  // A point within rounding of the hidden facet's plane lies on it.
  const Real below = hidden.height < 0 ? -hidden.height : Real(0);
  const Real share = seen.height / (seen.height + below), rest = below / (seen.height + below);
  for (int x = 0; x < 6; ++x) heir.normal[x] = share * hidden.normal[x] + rest * seen.normal[x];
  heir.vertex = seen.vertex;
  heir.vertex[slot] = point;
  heir.neighbour[slot] = seen.neighbour[slot];
  const auto back = std::find(hidden.neighbour.begin(), hidden.neighbour.end(), visible);
  if (back == hidden.neighbour.end()) return false;
  *back = id;
  measure(heir);
  return heir.distance == heir.distance;
}

// Heirs of one facet, which stand together, meet each other where each replaces a different vertex.
template <class Real>
void Polytope6<Real>::join_siblings(int first) {
  const int count = static_cast<int>(horizon_.size());
  for (int begin = 0, end = 0; begin < count; begin = end) {
    while (end < count && horizon_[end].facet == horizon_[begin].facet) ++end;
    for (int a = begin; a < end; ++a) {
      auto& neighbour = facets_[first + a].neighbour;
      for (int b = begin; b < end; ++b) {
        if (a != b) neighbour[horizon_[b].slot] = first + b;
      }
    }
  }
}

// Two heirs meet along each ridge that holds the new point: a hash table brings them together. False when a
// ridge has one owner or more than two: then rounding has made the horizon cross itself.
template <class Real>
bool Polytope6<Real>::join_heirs(int first) {
  const int end = used_;
  std::size_t size = 256;
  while (size < 8 * static_cast<std::size_t>(end - first)) size *= 2;
  if (seams_.size() < size) seams_.assign(size, Seam{0, round_, 0, 0});
  Seam* const table = seams_.data();
  const std::size_t mask = size - 1;
  const std::uint64_t* const names = names_.data();
  Facet* const facets = facets_.data();
  const int round = ++round_;
  int open = 0;
  for (int id = first; id < end; ++id) {
    Facet& heir = facets[id];
    std::uint64_t all = 0;
    for (int v : heir.vertex) all ^= names[v];
    for (int j = 0; j < 6; ++j) {
      if (heir.neighbour[j] >= 0) continue;
      const std::uint64_t name = all ^ names[heir.vertex[j]];
      std::size_t at = name & mask;
      while (table[at].stamp == round && table[at].name != name) at = (at + 1) & mask;
      Seam& seam = table[at];
      if (seam.stamp != round) {
        seam = {name, round, id, j};
        ++open;
        continue;
      }
      if (seam.facet < 0) return false;
      heir.neighbour[j] = seam.facet;
      facets[seam.facet].neighbour[seam.slot] = id;
      seam.facet = -1;
      --open;
    }
  }
  return open == 0;
}

template <class Real>
typename Polytope6<Real>::Outcome Polytope6<Real>::add_point(int seed, int point) {
  mark_visible(seed, points_[point]);
  const int first = used_;
  if (first + static_cast<int>(horizon_.size()) > kMaxFacets) return Outcome::kTooLarge;
  for (const Ridge& ridge : horizon_) {
    if (!make_heir(ridge.facet, ridge.slot, point)) return Outcome::kGaveUp;
  }
  join_siblings(first);
  if (!join_heirs(first)) return Outcome::kGaveUp;
  for (int id : visible_) facets_[id].alive = false;
  for (int id = first; id < used_; ++id) push(id);
  return Outcome::kInside;
}

template class Polytope6<double>;
template class Polytope6<Quad>;

}  // namespace evograsp::sim

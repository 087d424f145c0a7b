#include "sim/polytope6.h"

#include <algorithm>

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
  used_ = 0;
  inverses_.clear();
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
  Matrix edges;
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
    facet.inverse = static_cast<int>(inverses_.size());
    facet.parent = -1;
    Matrix inverse;
    for (int i = 0, k = 0; i < 7; ++i) {
      if (i == o) continue;
      facet.vertex[k] = corner[i];
      facet.neighbour[k] = i;
      for (int x = 0; x < 6; ++x) inverse[k][x] = gradient[i][x] - gradient[o][x];
      ++k;
    }
    inverses_.push_back(inverse);
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
  facet.inverse = -1;
  facet.mark = 0;
  facet.alive = true;
  return used_++;
}

template <class Real>
void Polytope6<Real>::push(int facet) {
  const Real distance = facets_[facet].distance;
  if (distance > radius_) return;  // the answer is nearer: it will never be looked at
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
  radius_ = 4;  // an upper bound: no point is that long
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
    if (reach < radius_) {
      radius_ = reach;
      for (int x = 0; x < 6; ++x) direction_[x] = facet.normal[x] / facet.norm;
    }
    if (radius_ - facet.distance <= gap) return is_flat(id) ? Outcome::kInside : Outcome::kGaveUp;
    const Outcome added = add_point(id, e.high);
    if (added != Outcome::kInside) return added;
  }
  return Outcome::kGaveUp;
}

// Do the facet's vertices lie on its plane? Pivots multiply errors where facets are slivers.
template <class Real>
bool Polytope6<Real>::is_flat(int id) const {
  const Facet& facet = facets_[id];
  for (int v : facet.vertex) {
    if (!(magnitude(dot(facet.normal, points_[v]) - 1) <= Tolerance<Real>::kPlane * facet.norm)) return false;
  }
  return true;
}

template <class Real>
bool Polytope6<Real>::sees(int id, const Point& point) const {
  const Facet& facet = facets_[id];
  return dot(facet.normal, point) - 1 > Tolerance<Real>::kSeen * facet.norm;
}

// The facets that the point sees, reached from one of them, and the ridges where they end.
template <class Real>
void Polytope6<Real>::mark_visible(int seed, const Point& point) {
  const int seen = 2 * ++epoch_, hidden = seen + 1;
  visible_.assign(1, seed);
  horizon_.clear();
  facets_[seed].mark = seen;
  for (std::size_t at = 0; at < visible_.size(); ++at) {
    const int id = visible_[at];
    for (int k = 0; k < 6; ++k) {
      const int next = facets_[id].neighbour[k];
      int& mark = facets_[next].mark;
      if (mark == seen) continue;
      if (mark != hidden) mark = sees(next, point) ? seen : hidden;
      if (mark == seen) {
        visible_.push_back(next);
      } else {
        horizon_.push_back({id, k});
      }
    }
  }
}

template <class Real>
const typename Polytope6<Real>::Matrix& Polytope6<Real>::inverse_of(int id) {
  // Parents first: a chain of pivots leads back to a facet whose inverse is there.
  chain_.clear();
  for (int f = id; facets_[f].inverse < 0; f = facets_[f].parent) chain_.push_back(f);
  while (!chain_.empty()) {
    Facet& facet = facets_[chain_.back()];
    chain_.pop_back();
    facet.inverse = static_cast<int>(inverses_.size());
    inverses_.emplace_back();
    const Matrix& from = inverses_[facets_[facet.parent].inverse];
    Matrix& to = inverses_.back();
    const int k = facet.slot;
    const Point& p = points_[facet.vertex[k]];
    const Real scale = 1 / dot(from[k], p);
    for (int x = 0; x < 6; ++x) to[k][x] = from[k][x] * scale;
    for (int j = 0; j < 6; ++j) {
      if (j == k) continue;
      const Real along = dot(from[j], p);
      for (int x = 0; x < 6; ++x) to[j][x] = from[j][x] - along * to[k][x];
    }
  }
  return inverses_[facets_[id].inverse];
}

// The facet spanned by the point and the ridge opposite vertex `slot` of a visible facet.
template <class Real>
bool Polytope6<Real>::make_heir(int visible, int slot, int point) {
  const Point row = inverse_of(visible)[slot];
  const int id = new_facet();
  Facet& old = facets_[visible];
  Facet& heir = facets_[id];
  const Point& p = points_[point];
  const Real pivot = dot(row, p);
  if (!(pivot > 0)) return false;
  const Real step = (1 - dot(old.normal, p)) / pivot;
  for (int x = 0; x < 6; ++x) heir.normal[x] = old.normal[x] + step * row[x];
  heir.vertex = old.vertex;
  heir.vertex[slot] = point;
  heir.parent = visible;
  heir.slot = slot;
  const int beyond = old.neighbour[slot];
  heir.neighbour[slot] = beyond;
  old.neighbour[slot] = ~id;
  auto& back = facets_[beyond].neighbour;
  const auto at = std::find(back.begin(), back.end(), visible);
  if (at == back.end()) return false;
  *at = id;
  measure(heir);
  return heir.distance == heir.distance;
}

// Heirs meet in pairs: to find who shares the point and the ridge without vertex j with this one, turn about
// that ridge through the visible facets until the horizon comes back.
template <class Real>
bool Polytope6<Real>::join_heirs(int id) {
  Facet& heir = facets_[id];
  for (int j = 0; j < 6; ++j) {
    if (heir.neighbour[j] != -1) continue;
    int at = heir.parent, drop = j;
    int kept = facets_[heir.parent].vertex[heir.slot];
    for (std::size_t steps = 0;; ++steps) {
      const int next = facets_[at].neighbour[drop];
      if (next < 0) {
        Facet& other = facets_[~next];
        const auto opposite = std::find(other.vertex.begin(), other.vertex.end(), kept);
        if (opposite == other.vertex.end()) return false;
        heir.neighbour[j] = ~next;
        other.neighbour[opposite - other.vertex.begin()] = id;
        break;
      }
      const Facet& f = facets_[next];
      const auto entered = std::find(f.neighbour.begin(), f.neighbour.end(), at);
      const auto leave = std::find(f.vertex.begin(), f.vertex.end(), kept);
      if (entered == f.neighbour.end() || leave == f.vertex.end() || steps > visible_.size()) return false;
      kept = f.vertex[entered - f.neighbour.begin()];
      at = next;
      drop = static_cast<int>(leave - f.vertex.begin());
    }
  }
  return true;
}

template <class Real>
typename Polytope6<Real>::Outcome Polytope6<Real>::add_point(int seed, int point) {
  mark_visible(seed, points_[point]);
  const int first = used_;
  if (first + static_cast<int>(horizon_.size()) > kMaxFacets) return Outcome::kTooLarge;
  for (const Ridge& ridge : horizon_) {
    if (!make_heir(ridge.facet, ridge.slot, point)) return Outcome::kGaveUp;
  }
  for (int id = first; id < used_; ++id) {
    if (!join_heirs(id)) return Outcome::kGaveUp;
  }
  for (int id : visible_) facets_[id].alive = false;
  for (int id = first; id < used_; ++id) push(id);
  return Outcome::kInside;
}

template class Polytope6<double>;
template class Polytope6<Quad>;

}  // namespace evograsp::sim

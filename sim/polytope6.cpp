#include "sim/polytope6.h"

#include <algorithm>

#include "common/random.h"
#include "sim/six.h"

namespace evograsp::sim {
namespace {

using six::dot, six::invert, six::square_root, six::Tolerance;

constexpr int kMaxFacets = 1 << 18;  // far beyond any real grasp; bounds memory on hostile sets
constexpr int kDead = 1 << 10;       // distance of a facet that is no more: beyond any point
constexpr std::uint64_t kOneMore = std::uint64_t{1} << 32;  // a table entry counts in its upper half

constexpr int pack(int facet, int slot) {
  return 8 * facet + slot;
}

// Index of the first value that comes before all others, of n >= 1, by blocks with four runners each.
template <class Real, class Before>
int first_of(const Real* value, int n, Before before) {
  constexpr int kBlock = 64;
  const auto pick = [&](Real a, Real b) { return before(b, a) ? b : a; };
  Real best = value[0];
  int block = 0;
  for (int begin = 0; begin < n; begin += kBlock) {
    const int end = std::min(n, begin + kBlock);
    Real runner[4] = {value[begin], value[begin], value[begin], value[begin]};
    int i = begin;
    for (; i + 4 <= end; i += 4) {
      for (int k = 0; k < 4; ++k) runner[k] = pick(runner[k], value[i + k]);
    }
    for (; i < end; ++i) runner[0] = pick(runner[0], value[i]);
    const Real first = pick(pick(runner[0], runner[1]), pick(runner[2], runner[3]));
    block = before(first, best) ? begin : block;
    best = pick(best, first);
  }
  while (block + 1 < n && before(best, value[block])) ++block;
  return block;
}

template <class Real>
int first_least(const Real* value, int n) {
  return first_of(value, n, [](Real a, Real b) { return a < b; });
}

template <class Real>
int first_most(const Real* value, int n) {
  return first_of(value, n, [](Real a, Real b) { return a > b; });
}

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
  epoch_ = 0;
}

template <class Real>
void Polytope6<Real>::reserve(int facets) {
  if (facets <= static_cast<int>(facets_.size())) return;
  const std::size_t room = std::max<std::size_t>(2048, 2 * static_cast<std::size_t>(facets));
  facets_.resize(room);
  distance_.resize(room);
  visible_.resize(room + 1);
  heir_.resize(8 * room);
  horizon_.resize(6 * room + 1);
}

template <class Real>
void Polytope6<Real>::project(const Point& direction) {
  const Real* c = columns_.data();
  Real* const out = products_.data();
  const int n = count_;
  for (int i = 0; i < n; ++i) {
    out[i] = ((c[i] * direction[0] + c[n + i] * direction[1]) +
              (c[2 * n + i] * direction[2] + c[3 * n + i] * direction[3])) +
             (c[4 * n + i] * direction[4] + c[5 * n + i] * direction[5]);
  }
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
    project(u);
    const int low = first_least(products_.data(), count_), high = first_most(products_.data(), count_);
    const Real least = products_[low], most = products_[high];
    if (!(most > thin) || !(least < -thin)) return false;
    radius_ = std::min(radius_, std::min(most, -least));
    const Real from = s == 0 ? Real(0) : dot(u, base);
    corner[s] = most - from >= from - least ? high : low;
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
  reserve(7);
  used_ = 7;
  for (int o = 0; o < 7; ++o) {
    Facet& facet = facets_[o];
    facet.name = 0;
    for (int i = 0, k = 0; i < 7; ++i) {
      if (i == o) continue;
      facet.vertex[k] = corner[i];
      facet.name ^= names_[corner[i]];
      facet.neighbour[k++] = pack(i, o < i ? o : o - 1);
    }
    for (int x = 0; x < 6; ++x) facet.normal[x] = -7 * gradient[o][x];
    facet.mark = 0;
    facet.alive = true;
    distance_[o] = measure(facet);
  }
  return true;
}

template <class Real>
Real Polytope6<Real>::measure(Facet& facet) const {
  facet.norm = square_root(dot(facet.normal, facet.normal));
  return (1 + dot(facet.normal, centre_)) / facet.norm;
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
  for (;;) {
    const int id = first_least(distance_.data(), used_);
    // Nearer than this the hull has a facet, and farther ours are all: rounding has opened the surface.
    if (!(distance_[id] <= radius_ + gap)) return Outcome::kGaveUp;
    const Facet& facet = facets_[id];
    project(facet.normal);
    const int high = first_most(products_.data(), count_);
    const Real reach = (products_[high] + dot(facet.normal, centre_)) / facet.norm;
    if (!(reach > gap)) return Outcome::kOutside;
    if (reach <= radius_ + gap) {
      radius_ = std::min(radius_, reach);
      for (int x = 0; x < 6; ++x) direction_[x] = facet.normal[x] / facet.norm;
    }
    if (radius_ - distance_[id] <= gap) return Outcome::kInside;
    const Outcome added = add_point(id, high);
    if (added != Outcome::kInside) return added;
  }
}

// The facets that the point sees, reached from one of them, and the ridges where they end. A facet with
// several seen neighbours is looked at as often: that costs less than to ask whether it was.
template <class Real>
void Polytope6<Real>::mark_visible(int seed, const Point& point) {
  const int seen = ++epoch_;
  const Real least = Tolerance<Real>::kSeen;
  Facet* const facets = facets_.data();
  facets[seed].mark = seen;
  facets[seed].height = dot(facets[seed].normal, point) - 1;
  visible_[0] = seed;
  int count = 1, ridges = 0;
  for (int at = 0; at < count; ++at) {
    const Facet& from = facets[visible_[at]];
    for (int k = 0; k < 6; ++k) {
      const int next = from.neighbour[k] >> 3;
      Facet& facet = facets[next];
      facet.height = dot(facet.normal, point) - 1;
      const bool known = facet.mark == seen;
      const bool sees = known | (facet.height > least * facet.norm);
      facet.mark = sees ? seen : facet.mark;
      visible_[count] = next;
      count += sees & !known;
      heir_[pack(at, k)] = sees ? -1 : ridges;
      horizon_[ridges] = pack(at, k);
      ridges += !sees;
    }
  }
  ridges_ = ridges;
  for (int at = 0; at < count; ++at) {
    facets[visible_[at]].alive = false;
    distance_[visible_[at]] = kDead;
  }
}

// Links the new facet `id` over a ridge of the horizon: to the hidden facet beyond the ridge and, across
// ridges that hold the new point, to heirs of the same seen facet; its other ridges become seams.
template <class Real>
void Polytope6<Real>::link_heir(int ridge, int id) {
  const int at = ridge >> 3, slot = ridge & 7, first = id - heir_[ridge];
  Facet& heir = facets_[id];
  const int beyond = facets_[visible_[at]].neighbour[slot];
  int open = open_;
  for (int k = 0; k < 6; ++k) {
    const int sibling = heir_[pack(at, k)];
    heir.neighbour[k] = pack(first + sibling, slot);
    seams_[open] = {heir.name ^ names_[heir.vertex[k]], pack(id, k)};
    open += sibling < 0;
  }
  open_ = open;
  heir.neighbour[slot] = beyond;
  facets_[beyond >> 3].neighbour[beyond & 7] = pack(id, slot);
}

// The facets spanned by the point and each ridge of the horizon. False when one has no plane.
template <class Real>
bool Polytope6<Real>::make_heirs(int point) {
  const int first = used_;
  if (seams_.size() < 6 * static_cast<std::size_t>(ridges_)) {
    seams_.resize(12 * static_cast<std::size_t>(ridges_));
    unpaired_.resize(12 * static_cast<std::size_t>(ridges_));
  }
  open_ = 0;
  bool sound = true;
  for (int i = 0; i < ridges_; ++i) {
    const int slot = horizon_[i] & 7;
    Facet& heir = facets_[first + i];
    const Facet& seen = facets_[visible_[horizon_[i] >> 3]];
    const Facet& hidden = facets_[seen.neighbour[slot] >> 3];
    // A point within rounding of the hidden facet's plane lies on it.
    const Real below = hidden.height < 0 ? -hidden.height : Real(0);
    const Real share = seen.height / (seen.height + below), rest = below / (seen.height + below);
    for (int x = 0; x < 6; ++x) heir.normal[x] = share * hidden.normal[x] + rest * seen.normal[x];
    heir.name = seen.name ^ names_[seen.vertex[slot]] ^ names_[point];
    heir.vertex = seen.vertex;
    heir.vertex[slot] = point;
    heir.mark = 0;
    heir.alive = true;
    const Real distance = distance_[first + i] = measure(heir);
    // No NaN, of a type that std::isnan may not know.
    sound &= distance == distance;  // NOLINT(misc-redundant-expression)
    link_heir(horizon_[i], first + i);
  }
  used_ = first + ridges_;
  return sound;
}

// One pass: seams meet their partners in a table by some bits of their names. An entry that counts two holds
// the sum of their indices. Those that met nobody, or a crowd, are left: their number is returned.
template <class Real>
int Polytope6<Real>::pair_seams(int count, int shift) {
  std::size_t size = 256;
  while (size < 8 * static_cast<std::size_t>(count)) size *= 2;
  if (table_.size() < size) table_.resize(size);
  std::uint64_t* const table = table_.data();
  const Seam* const seams = seams_.data();
  Facet* const facets = facets_.data();
  const std::uint64_t mask = size - 1;
  for (int i = 0; i < count; ++i) table[(seams[i].name >> shift) & mask] += kOneMore + i;
  int left = 0;
  for (int i = 0; i < count; ++i) {
    const Seam seam = seams[i];
    const std::uint64_t other = table[(seam.name >> shift) & mask] - 2 * kOneMore - i;
    const Seam partner = seams[other < static_cast<std::uint64_t>(count) ? other : i];
    const bool met = partner.name == seam.name && partner.owner != seam.owner;
    facets[seam.owner >> 3].neighbour[seam.owner & 7] = partner.owner;
    unpaired_[left] = seam;
    left += !met;
  }
  for (int i = 0; i < count; ++i) table[(seams[i].name >> shift) & mask] = 0;
  return left;
}

// Two heirs meet along each ridge that holds the new point. False when a ridge has one owner or more than
// two: then rounding has made the horizon cross itself.
template <class Real>
bool Polytope6<Real>::join_seams() {
  int count = open_;
  for (int shift = 0; count > 0 && shift <= 40; shift += 8) {
    count = pair_seams(count, shift);
    std::swap(seams_, unpaired_);
  }
  return count == 0;
}

template <class Real>
typename Polytope6<Real>::Outcome Polytope6<Real>::add_point(int seed, int point) {
  mark_visible(seed, points_[point]);
  if (used_ + ridges_ > kMaxFacets) return Outcome::kTooLarge;
  reserve(used_ + ridges_);
  if (!make_heirs(point) || !join_seams()) return Outcome::kGaveUp;
  return Outcome::kInside;
}

template class Polytope6<double>;
template class Polytope6<Quad>;

}  // namespace evograsp::sim

// The expanding polytope behind Epsilon: how deep the origin lies inside the convex hull of points in six
// dimensions, without building the hull. Internal to the room; quality.h is the door.
//
// A simplex of hull points grows, always at the facet nearest the origin, by the point that is farthest along
// that facet's normal, until no point lies beyond the nearest facet: then that facet is on the hull and its
// distance is the answer. Facets far from the origin, nearly all of a six-dimensional hull, are never made.
//
// Planes are kept in the polar of a point c inside the simplex: normal . (x - c) = 1. A facet that takes over
// a ridge from a visible one differs from it in one vertex, so its normal and the inverse of its vertex
// matrix follow by one simplex pivot (36 products) instead of a 6x6 solve.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace evograsp::sim {

// 113-bit arithmetic in software: slow, the same everywhere, for the few sets that defeat 53 bits.
__extension__ typedef __float128 Quad;

// Real: double or Quad. Not thread-safe; allocates nothing once warm.
template <class Real>
class Polytope6 {
 public:
  using Point = std::array<Real, 6>;

  enum class Outcome {
    kInside,    // radius() is the answer
    kOutside,   // the origin is not strictly inside, or the set is flat
    kTooLarge,  // more facets than memory is given for
    kGaveUp,    // rounding broke the surface: another arithmetic or other points must answer
  };

  struct Facet {
    std::array<int, 6> vertex;  // points
    std::array<int, 6>
        neighbour;     // facet across the ridge opposite each vertex; once dead: ~heir on the horizon
    Point normal;      // normal . (x - centre) = 1 on the plane
    Real norm;         // of normal: 1 / distance of the plane from the centre
    Real distance;     // of the plane from the origin; negative: the origin is outside
    int inverse;       // index into inverses_, -1: not computed
    int parent, slot;  // pivoted from `parent` by replacing its vertex number `slot`
    int mark;
    bool alive;
  };

  // Points of length at most about 1. Absolute error of the radius: about 1e-12 (double).
  Outcome expand(std::span<const Point> points);

  Real radius() const { return radius_; }                       // of the last expand(), kInside
  const Point& direction() const { return direction_; }         // unit normal of the hull's nearest facet
  const std::vector<Facet>& facets() const { return facets_; }  // what the answer rests on: the alive ones
  int size() const { return used_; }                            // facets in use, dead or alive

 private:
  using Matrix = std::array<Point, 6>;  // row k . vertex j = (k == j)
  struct Entry {
    Real distance;
    int facet;
  };
  struct Extent {
    int low, high;     // points farthest against and along a direction
    Real least, most;  // their products with it
  };

  void load(std::span<const Point> points);
  Extent extent(const Point& direction);
  bool pick_simplex(std::array<int, 7>& corner);
  bool build_simplex(const std::array<int, 7>& corner);
  bool sees(int facet, const Point& point) const;
  Outcome add_point(int facet, int point);  // kInside: done, go on
  void mark_visible(int facet, const Point& point);
  bool make_heir(int visible, int slot, int point);
  bool join_heirs(int heir);
  bool is_flat(int facet) const;
  const Matrix& inverse_of(int facet);
  void measure(Facet& facet);
  void push(int facet);
  int pop();
  int new_facet();

  int count_ = 0;
  std::vector<Point> points_;  // about the centre once it is known
  std::vector<Real> columns_;  // the same by coordinate, for extent()
  std::vector<Real> products_;
  Point centre_{};
  std::vector<Facet> facets_;
  int used_ = 0;
  std::vector<Matrix> inverses_;
  std::vector<Entry> heap_;
  std::vector<int> visible_, chain_;
  struct Ridge {
    int facet, slot;
  };
  std::vector<Ridge> horizon_;
  int epoch_ = 0;
  Real radius_ = 0;
  Point direction_{};
};

}  // namespace evograsp::sim

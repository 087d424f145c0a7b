// The expanding polytope behind Epsilon: how deep the origin lies inside the convex hull of points in six
// dimensions, without building the hull. Internal to the room; quality.h is the door.
//
// A simplex of hull points grows, always at the facet nearest the origin, by the point that is farthest along
// that facet's normal, until no point lies beyond the nearest facet: then that facet is on the hull and its
// distance is the answer. Facets far from the origin, nearly all of a six-dimensional hull, are never made.
//
// Planes are kept in the polar of a point c inside the simplex: normal . (x - c) = 1. There the planes
// through a ridge form a line, so a facet that replaces a visible one A beyond the ridge it shares with a
// hidden one B has its normal between theirs, where the new point lies on its plane: a convex combination
// with the point's heights over A and B as weights. No system is ever solved after the first simplex, and
// rounding errors never grow.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
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

  // Two cache lines for double.
  struct alignas(64) Facet {
    Point normal;                  // normal . (x - centre) = 1 on the plane
    Real norm;                     // of normal: 1 / distance of the plane from the centre
    Real distance;                 // of the plane from the origin; negative: the origin is outside
    Real height;                   // normal . (x - centre) - 1 of the point being added, once marked
    std::array<int, 6> neighbour;  // facet across the ridge opposite each vertex
    std::array<int, 6> vertex;     // points
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
  struct Entry {
    Real distance;
    int facet;
  };
  struct Ridge {
    int facet, slot;
  };
  // A ridge between two heirs, named by its vertices; facet -1 once both have met. Of this round if stamped
  // so.
  struct Seam {
    std::uint64_t name;
    int stamp;
    int facet, slot;
  };
  struct Extent {
    int low, high;     // points farthest against and along a direction
    Real least, most;  // their products with it
  };

  void load(std::span<const Point> points);
  Extent extent(const Point& direction);
  bool pick_simplex(std::array<int, 7>& corner);
  bool build_simplex(const std::array<int, 7>& corner);
  Outcome add_point(int facet, int point);  // kInside: done, go on
  void mark_visible(int facet, const Point& point);
  bool make_heir(int visible, int slot, int point);
  void join_siblings(int first);
  bool join_heirs(int first);
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
  std::vector<Entry> heap_;
  std::vector<int> visible_;
  std::vector<std::uint64_t> names_;  // of points: random bits
  std::vector<Seam> seams_;           // hash table of join_heirs()
  int round_ = 0;
  std::vector<Ridge> horizon_;
  int epoch_ = 0;
  Real radius_ = 0;
  Point direction_{};
};

}  // namespace evograsp::sim

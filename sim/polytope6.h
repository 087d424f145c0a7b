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
//
// What a grasp's polytope looks like cannot be predicted, so neither can a branch that depends on it: a
// processor that guesses wrong waits as long as fifty additions take. Hence the loops below compute both
// sides, write always, and count up by whether the write was meant.
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

  // Where two facets meet, seen from one of them: the other, and the vertex of the other that is not shared.
  struct Link {
    int facet = -1, slot = 0;
  };

  // Two cache lines for double.
  struct alignas(64) Facet {
    Point normal;                  // normal . (x - centre) = 1 on the plane
    Real norm;                     // of normal: 1 / distance of the plane from the centre
    Real height;                   // normal . (x - centre) - 1 of the point being added, once looked at
    std::uint64_t name;            // of its vertices: the names of the points, exclusive-ored
    std::array<int, 6> neighbour;  // across the ridge opposite each vertex, packed: see across()
    std::array<int, 6> vertex;     // points
    int mark;
    bool alive;

    Link across(int slot) const { return {neighbour[slot] >> 3, neighbour[slot] & 7}; }
  };

  // Points of length at most about 1. Absolute error of the radius: about 1e-12 (double).
  Outcome expand(std::span<const Point> points);

  Real radius() const { return radius_; }                       // of the last expand(), kInside
  const Point& direction() const { return direction_; }         // unit normal of the hull's nearest facet
  const std::vector<Facet>& facets() const { return facets_; }  // what the answer rests on: the alive ones
  int size() const { return used_; }                            // facets in use, dead or alive

 private:
  // A ridge of an heir that holds the new point, named by its other vertices, and its owner, packed.
  struct Seam {
    std::uint64_t name;
    int owner;
  };

  void load(std::span<const Point> points);
  void project(const Point& direction);
  bool pick_simplex(std::array<int, 7>& corner);
  bool build_simplex(const std::array<int, 7>& corner);
  Outcome add_point(int facet, int point);  // kInside: done, go on
  void mark_visible(int facet, const Point& point);
  bool make_heirs(int point);
  void link_heir(int ridge, int id);
  bool join_seams();
  int pair_seams(int count, int shift);
  Real measure(Facet& facet) const;
  void reserve(int facets);

  int count_ = 0;
  std::vector<Point> points_;         // about the centre once it is known
  std::vector<Real> columns_;         // the same by coordinate, for project()
  std::vector<Real> products_;        // of every point and the direction last asked for
  std::vector<std::uint64_t> names_;  // of points: random bits
  Point centre_{};
  std::vector<Facet> facets_;
  std::vector<Real> distance_;  // of each facet's plane from the origin; a dead one's is beyond all
  int used_ = 0;
  int epoch_ = 0;
  // Of one round, with room for every facet: lengths in the counts.
  std::vector<int> visible_;  // facets that the point sees
  std::vector<int> heir_;     // of visible facet i's slot k at 8 i + k: which of the round's heirs; -1: none
  std::vector<int> horizon_;  // ridges where the seen facets end: 8 i + k
  std::vector<Seam> seams_, unpaired_;
  std::vector<std::uint64_t> table_;  // all zero between rounds
  int ridges_ = 0, open_ = 0;
  Real radius_ = 0;
  Point direction_{};
};

}  // namespace evograsp::sim

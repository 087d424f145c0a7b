// How good a grasp is: contacts to wrenches, wrenches to epsilon.
//
// Epsilon is the radius of the largest ball about the origin inside the convex hull of all edge wrenches
// (Ferrari and Canny, "Planning optimal grasps", ICRA 1992: the L1 unit grasp wrench space). It is exact to
// rounding, not sampled: an expanding polytope grows toward the facet nearest the origin until that facet
// lies on the hull (the idea of Zheng, "An efficient algorithm for a grasp quality measure", IEEE T-RO 29(2),
// 2013).
//
// Bits: every function here gives the same bits on any x86-64 machine and with either compiler.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "sim/simulator.h"

namespace evograsp::sim {

// Force, then torque about the centre of mass divided by the torque scale: fx fy fz tx ty tz.
using Wrench = std::array<double, 6>;

// How a friction cone becomes a pyramid of edge forces.
struct ConeModel {
  int edges = 8;  // at least 3
  // false: the edge's normal part is 1, edge = n + mu (cos t u + sin t v), GraspIt!'s convention (Miller and
  // Allen, "GraspIt!", IEEE RAM 11(4), 2004). true: the same direction scaled to length 1.
  bool unit_length = false;
};

// Radius of the largest origin-centred ball inside the convex hull of a wrench set; 0 when the origin is not
// strictly inside. One a thread; allocates nothing once warm.
class Epsilon {
 public:
  Epsilon();
  ~Epsilon();
  Epsilon(Epsilon&&) noexcept;
  Epsilon& operator=(Epsilon&&) noexcept;

  // Any number of wrenches in any order, duplicates and flat sets included. Absolute error below 1e-10 times
  // the longest wrench (commonly 1e-15). Never NaN, never negative: a set with a NaN or infinity gives 0.
  double operator()(std::span<const Wrench> wrenches);

  // After a call that gave more than 0: the unit direction along which the hull reaches only that far. To
  // resist a disturbance opposite to it the grasp is at its weakest.
  const Wrench& weakest() const;

  // Did the last call give 0 because the set was too large to answer (over 262,144 facets made: thousands of
  // wrenches in every direction)? Never seen with wrenches of contacts.
  bool gave_up() const;

 private:
  struct Solver;
  std::unique_ptr<Solver> solver_;
};

// Quality of contact sets, with the memory it needs: one a thread (a Workspace holds one). Allocates nothing
// once warm.
class Quality {
 public:
  // Values below min_quality are no force closure: they are returned as 0.
  explicit Quality(const ConeModel& cone = {}, double min_quality = 1e-6);

  // Epsilon of the contacts; com and the contacts in the same frame, m; rho: torque scale, m, > 0. Fewer than
  // three contacts give 0 without looking: two point contacts cannot resist a torque about the line through
  // them.
  double operator()(std::span<const Contact> contacts, const Vec3& com, double rho);

  // The edge wrenches, contact by contact, `edges` each: f = edge, torque = (point - com) x f / rho. Edge 0
  // of a contact points (apart from its normal part) along the tangential part of point - com, or, where that
  // vanishes, along the tangential part of the way to the farthest other contact: a rigid motion
  // of object and contacts turns the pyramids with them, so epsilon does not depend on where the object
  // stands. Valid until the next call.
  std::span<const Wrench> wrenches(std::span<const Contact> contacts, const Vec3& com, double rho);

 private:
  ConeModel cone_;
  double min_quality_;
  std::vector<std::array<double, 2>> circle_;  // cosine and sine of each edge's angle
  std::vector<Wrench> wrenches_;
  Epsilon epsilon_;
};

// What the whole hull says, for reports: far slower than Epsilon (milliseconds), allocates.
struct WrenchHull {
  bool force_closure = false;  // the origin is strictly inside
  double epsilon = 0;
  double volume = 0;  // of the 6-D hull, in the units of the wrenches
  Wrench weakest{};   // unit wrench along which the hull reaches only epsilon; zero without force closure
};

// By qhull (Barber, Dobkin and Huhdanpaa, ACM TOMS 22(4), 1996). Flat sets (fewer than 7 wrenches, all
// contacts in one line, ...) have volume 0 and no force closure. kInvalid for NaN or infinity, kInternal when
// qhull gives up. Thread-safe.
Result<WrenchHull> wrench_hull(std::span<const Wrench> wrenches);

}  // namespace evograsp::sim

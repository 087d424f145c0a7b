// Closing: every motor pulls its tendon until all its joints rest on something or on their limits.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/hand_state.h"
#include "sim/world.h"

namespace evograsp::sim {

// Scratch memory of the closing; one a slot.
class Closing {
 public:
  Closing(const HandModel& hand, int obstacles);

  // Closes the motors one after another, in the hand's order, from the joint values in `state`.
  //
  // A motor's travel s moves its joint j to q_j + ratio_j s. A joint stops at its limit, or when a part of
  // its own link or of a link beyond it comes within `tolerance` of an obstacle and is not moving away from
  // it; joints beyond go on curling (adaptive wrap), so do the motor's other branches. Obstacles are the
  // table, the objects and the hand's own other parts where they stand at that moment (a thumb that closes
  // after the fingers rests on them; HandModel::may_collide names the pairs that count). Parts rest with a
  // gap between 0 and the tolerance and never pass through anything, however thin.
  //
  // Event-driven conservative advancement (Mirtich, "Impulse-based dynamic simulation of rigid body systems",
  // 1996, 2.3): each pair keeps a separating direction n and a bound on how far the motor can travel until
  // the gap along n is used up, from the part's exact speed along n now and a bound on its acceleration ever:
  //   gap(s) >= gap(0) - v s - A s^2 / 2.
  // The pair whose bound runs out first is looked at next.
  void close(const HandModel& hand, const PosedWorld& world, double tolerance, HandState& state);

  // Distance queries of the last close(): for measurements.
  int queries() const { return queries_; }

 private:
  struct Pair {
    const Shape* shape;  // of the obstacle
    const Pose* pose;
    const Obstacle* obstacle;         // null when it is a part of the hand
    int part;                         // of the hand
    Vec3 normal;                      // separates them: obstacle below, part above
    double obstacle_top;              // largest coordinate of the obstacle along normal
    double gap, speed, acceleration;  // along normal, as of travel `at`
    double at, due;                   // travel when last looked at, and until which the gap is proven open
  };
  struct PartMotion {
    HandModel::MotionBound bound;
    JointSet active = 0;  // of the joints that move it
    double end = 0;       // travel at which the last of them stops
  };

  void gather(const HandMotor& motor);
  void add_pair(int part, const Obstacle* obstacle, const Shape& shape, const Pose& pose, const Vec3& centre);
  void advance();
  void pose_link(int link, double s);
  void pose_part(int part, double s);
  double lowest(int part, const Vec3& normal) const;
  double speed_along(int part, const Vec3& normal, const Vec3* point) const;
  bool renew_by_direction(Pair& pair, double s);
  bool renew_by_distance(Pair& pair, double s);
  bool out_of_reach(const Pair& pair) const;
  void set_due(Pair& pair, double s, double room);
  void stop(JointSet joints, double s);
  void refresh_motion(JointSet changed);

  // Constant during one close().
  const HandModel* hand_ = nullptr;
  const PosedWorld* world_ = nullptr;
  const HandMotor* motor_ = nullptr;
  HandState* state_ = nullptr;
  double tolerance_ = 0;
  // Of the motor that is closing.
  JointSet active_ = 0;
  std::vector<double> start_, stop_;       // [joint] value at s = 0, travel at which it stops
  std::vector<double> link_at_, part_at_;  // travel for which the pose in state_ is right
  std::vector<PartMotion> motion_;         // [part]
  std::vector<Pair> pairs_;
  int queries_ = 0;
};

}  // namespace evograsp::sim

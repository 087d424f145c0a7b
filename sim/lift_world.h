// The Bullet world of one lift test. Internal to the room; lift.h is the door.
#pragma once

#include <memory>

#include "sim/lift.h"

namespace evograsp::sim {

// A table that sinks, an object on it, a hand fixed by its palm whose motors close. Not thread-safe; one a
// test.
class LiftWorld {
 public:
  // The setup is checked already (lift_test does).
  LiftWorld(const LiftSetup& setup, const LiftOptions& options);
  ~LiftWorld();
  LiftWorld(const LiftWorld&) = delete;
  LiftWorld& operator=(const LiftWorld&) = delete;

  // One step during which the hand accelerates by `acceleration` and the table sinks at `table_speed`, m/s.
  void step(const Vec3& acceleration, double table_speed);
  void remove_table();
  // From now on half of each motor's torque squeezes and the other half keeps the joint where it is, as a
  // servo does that has closed. Opposed pure torques would drift together at the least push.
  void hold_closed();

  Pose object() const;        // frame at the centre of mass, along the principal axes of inertia
  bool touches_hand() const;  // the object, now
  double joint(int index) const;
  double fastest_joint() const;  // rad/s or m/s, of the joints that motors close

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace evograsp::sim

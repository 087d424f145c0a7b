// The dynamic test that a grasp must survive to be worth the name: closed by motors of limited torque,
// lifted, held, shaken. For champions and reports, not for training: about a hundred milliseconds a test.
//
// A Bullet multibody world (Featherstone's articulated bodies, sequential impulses) of its own for every
// test: nothing carries over from one to the next. The palm never moves: the world is the palm's frame of
// motion. Lifting the hand is lowering the table under it, and the hand's accelerations act on the object as
// changes of gravity. That is the same mechanics (translations only), and leaves the object's slip as its
// motion in the world.
//
// Bits: equal on every x86-64 machine with the same Bullet library, which is bound to trigonometry of our own
// (sim/lift_libm.h).
#pragma once

#include <span>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "sim/simulator.h"

namespace evograsp::sim {

struct LiftOptions {
  double close_s = 1.2;  // at most; less when the fingers come to rest
  double lift_m = 0.10;
  double lift_s = 0.5;
  double hold_s = 1.0;
  double shake_m = 0.015;    // out and back along +x, -x, +y, -y, +z, -z in turn
  double shake_s = 0.2;      // each
  double max_slip_m = 0.03;  // more, at any time, is a lost grasp
  double step_s = 1.0 / 240;
  double gravity = 9.81;  // m/s^2
};

// What is tested: the hand about the object, both on the table (its top is the plane z = 0).
struct LiftSetup {
  const proto::HandBundle* hand = nullptr;
  Pose palm;                       // X_WH where the hand stopped
  std::span<const double> joints;  // at the start, one each: the preset, or the joints of the closed hand
  const proto::ObjectBundle* object = nullptr;
  Pose object_pose;            // X_WB
  std::span<const double> mu;  // friction of each link and the object
  double table_mu = 0.5;       // of the object and the table
};

struct LiftReport {
  bool held = false;  // touched by the hand and never slipped by more than max_slip_m until the end
  double slip = 0;    // m: how far the object's centre of mass has moved in the hand since it closed
  double max_displacement = 0;  // m: the largest value of that on the way
  double turn = 0;              // rad: how far the object has turned in the hand since it closed
  double lost_at = -1;          // s after closing when the grasp was lost; -1: never
  double time = 0;              // s simulated, closing included
  std::vector<double> joints;   // at the end
};

// Errors (kInvalid): not one joint value a joint, not one mu a link, an object without mass or parts, a hand
// that Bullet cannot take, a pose that is not finite. A grasp that explodes is a lost one, not an error.
// Thread-safe.
Result<LiftReport> lift_test(const LiftSetup& setup, const LiftOptions& options = {});

// The test of one attempt of a simulator's trial: the hand closes from its preset at the pose where the
// attempt stopped it. Only the target stands on the table. Friction, size and mass (with the scene's jitter)
// are the placement's.
Result<LiftReport> lift_test(const Simulator& simulator, const Placements& placements, int target,
                             const GraspReport& attempt, const LiftOptions& options = {});

}  // namespace evograsp::sim

#include "sim/lift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "assets/assets.h"
#include "common/det_math.h"

namespace evograsp::sim {
namespace {

// A parallel-jaw gripper above an object that stands in the middle of the table.
class Bench {
 public:
  explicit Bench(const std::string& object, const std::string& hand = "parallel_jaw") {
    auto loaded_hand = assets::load_hand(hand, EVOGRASP_SOURCE_DIR);
    auto loaded_object = assets::load_object(object, {});
    if (!loaded_hand || !loaded_object) std::abort();
    hand_ = loaded_hand->bundle;
    object_ = loaded_object->bundle;
    preset_.assign(hand_.preset().begin(), hand_.preset().end());
    height_ = object_.resting(0).height();
    grip_at(Vec3(0, 0, height_));
    rub(0.8);
    setup_.hand = &hand_;
    setup_.object = &object_;
    setup_.joints = preset_;
    setup_.object_pose.rotation = from_proto(object_.resting(0).orientation());
    setup_.object_pose.position = Vec3(0, 0, height_);
  }

  // Turns the palm down and brings the point between the jaws' tips to `point`.
  void grip_at(const Vec3& point) {
    setup_.palm.rotation = rotation_about(Vec3::UnitY(), det::kPi);
    setup_.palm.position = point - setup_.palm.rotation * from_proto(hand_.tool_point());
  }
  void rub(double mu) {
    mu_.assign(static_cast<std::size_t>(hand_.link_size()), mu);
    setup_.mu = mu_;
  }

  LiftReport lift() const {
    auto report = lift_test(setup_);
    EXPECT_TRUE(report) << report.error().message;
    return report.value_or(LiftReport{});
  }

  LiftSetup setup_;
  proto::HandBundle hand_;
  proto::ObjectBundle object_;
  double height_ = 0;

 private:
  std::vector<double> preset_, mu_;
};

TEST(LiftTest, JawsHoldACubeAndACylinderStill) {
  for (const char* object : {"cube_6cm", "cylinder"}) {
    const LiftReport report = Bench(object).lift();
    EXPECT_TRUE(report.held) << object << " lost after " << report.lost_at << " s";
    EXPECT_LT(report.max_displacement, 0.005) << object;
    EXPECT_LT(report.turn, 0.2) << object;
    EXPECT_GT(report.time, 2.7) << object << ": lifted, held and shaken";
  }
}

TEST(LiftTest, WithoutFrictionTheCubeStaysBehind) {
  Bench bench("cube_6cm");
  bench.rub(0.001);
  const LiftReport report = bench.lift();
  EXPECT_FALSE(report.held);
  EXPECT_GT(report.slip, 0.03);
  EXPECT_LT(report.lost_at, 0.6) << "already in the lift";
}

// 86 g x (9.81 + 7.4) m/s^2 needs 1.5 N; two jaws of 40 N hold with friction above 0.02.
TEST(LiftTest, FrictionNeededIsWeightOverGrip) {
  Bench bench("cube_6cm");
  bench.rub(0.1);
  EXPECT_TRUE(bench.lift().held);
  for (auto& motor : *bench.hand_.mutable_motor()) motor.set_max_torque(4);
  EXPECT_FALSE(bench.lift().held)
      << "two times 4 N and friction 0.1 carry 0.8 N, less than the cube's weight";
  for (auto& motor : *bench.hand_.mutable_motor()) motor.set_max_torque(40);
  bench.object_.set_mass(5);
  EXPECT_FALSE(bench.lift().held) << "8 N of friction under 49 N of weight";
}

TEST(LiftTest, WhatTheHandDoesNotReachStaysOnTheTable) {
  Bench bench("cube_6cm");
  bench.grip_at(Vec3(0, 0, bench.height_ + 0.3));
  const LiftReport report = bench.lift();
  EXPECT_FALSE(report.held);
  EXPECT_GE(report.lost_at, 0);
  EXPECT_NEAR(report.slip, 0.03, 0.005) << "the table takes it along; nothing else moves it";
  EXPECT_LT(report.turn, 0.01);
}

TEST(LiftTest, RepeatsToTheBitAfterOtherTests) {
  const Bench cube("cube_6cm");
  Bench cylinder("cylinder");
  const LiftReport first = cube.lift();
  for (int i = 0; i < 3; ++i) {
    cylinder.grip_at(Vec3(0.002 * i, 0.001, cylinder.height_));
    cylinder.lift();
    const LiftReport again = cube.lift();
    EXPECT_EQ(again.slip, first.slip);
    EXPECT_EQ(again.turn, first.turn);
    EXPECT_EQ(again.joints, first.joints);
  }
}

TEST(LiftTest, JointsStopAtTheirLimits) {
  Bench bench("cube_6cm", "meka_h2");
  bench.grip_at(Vec3(0, 0, bench.height_ + 0.5));  // nothing to close on
  const LiftReport report = bench.lift();
  ASSERT_EQ(static_cast<int>(report.joints.size()), bench.hand_.joint_size());
  for (int j = 0; j < bench.hand_.joint_size(); ++j) {
    const auto& joint = bench.hand_.joint(j);
    EXPECT_LT(report.joints[j], joint.upper() + 0.02) << joint.name();
    EXPECT_GT(report.joints[j], joint.lower() - 0.02) << joint.name();
  }
}

TEST(LiftTest, RefusesWhatItCannotSimulate) {
  const auto refused = [](auto spoil) {
    Bench bench("cube_6cm");
    spoil(bench);
    const auto report = lift_test(bench.setup_);
    return !report && report.error().code == ErrorCode::kInvalid && !report.error().message.empty();
  };
  EXPECT_TRUE(refused([](Bench& b) { b.object_.clear_mass(); })) << "no mass";
  EXPECT_TRUE(refused([](Bench& b) { b.object_.clear_part(); })) << "no parts";
  EXPECT_TRUE(refused([](Bench& b) { b.setup_.joints = {}; })) << "no joints";
  EXPECT_TRUE(refused([](Bench& b) { b.setup_.mu = b.setup_.mu.first(1); })) << "too few frictions";
  EXPECT_TRUE(refused([](Bench& b) { b.hand_.mutable_motor(0)->set_joint(0, 99); })) << "no such joint";
  EXPECT_TRUE(refused([](Bench& b) {
    b.setup_.palm.position.x() = std::numeric_limits<double>::quiet_NaN();
  })) << "a pose that is no pose";
}

}  // namespace
}  // namespace evograsp::sim

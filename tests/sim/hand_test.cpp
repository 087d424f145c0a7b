// Hand kinematics against cases worked by hand, motion bounds against motion, and the rules of what may
// collide.
#include "sim/hand.h"

#include <gtest/gtest.h>

#include "sim/closing.h"
#include "tests/sim/random_shapes.h"
#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

// Two links in a row on revolute joints about y (negative angles lift), 40 mm apart, and a slider.
proto::HandBundle planar_hand() {
  proto::HandBundle hand;
  const auto link = [&](const char* name) {
    auto* l = hand.add_link();
    l->set_name(name);
    l->set_material("rubber");
    auto* part = l->add_part();
    part->mutable_capsule()->set_radius(0.005);
    part->mutable_capsule()->set_half_length(0.01);
    *part->mutable_pose() = to_proto(Pose{rotation_about(Vec3::UnitY(), det::kPi / 2), Vec3(0.02, 0, 0)});
  };
  link("palm");
  link("first");
  link("second");
  link("slider");
  const auto joint = [&](unsigned parent, const Vec3& at, const Vec3& axis, bool prismatic, double upper) {
    auto* j = hand.add_joint();
    j->set_parent_link(parent);
    *j->mutable_origin()->mutable_position() = to_proto(at);
    *j->mutable_axis() = to_proto(axis);
    j->set_prismatic(prismatic);
    j->set_lower(0);
    j->set_upper(upper);
  };
  joint(0, {0.05, 0, 0}, -Vec3::UnitY(), false, 2);
  joint(1, {0.04, 0, 0}, -Vec3::UnitY(), false, 2);
  joint(0, {0, 0.1, 0}, Vec3::UnitX(), true, 0.03);
  auto* motor = hand.add_motor();
  for (unsigned j : {0u, 1u}) {
    motor->add_joint(j);
    motor->add_ratio(j == 0 ? 1 : 0.5);
  }
  auto* slide = hand.add_motor();
  slide->add_joint(2);
  slide->add_ratio(1);
  for (int j = 0; j < 3; ++j) hand.add_preset(0);
  return hand;
}

TEST(Hand, ForwardKinematicsMatchesTheHandComputedCase) {
  const auto hand = HandModel::create(planar_hand());
  ASSERT_TRUE(hand) << hand.error().message;
  std::vector<Pose> links(4);
  // First joint a quarter turn: the finger points up (+z); second another quarter: back along -x.
  hand->forward(std::vector<double>{det::kPi / 2, det::kPi / 2, 0.02}, Pose{Mat3::Identity(), Vec3(1, 2, 3)},
                links);
  EXPECT_LT((links[1].position - Vec3(1.05, 2, 3)).norm(), 1e-12);
  EXPECT_LT((links[1].rotation.col(0) - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LT((links[2].position - Vec3(1.05, 2, 3.04)).norm(), 1e-12);
  EXPECT_LT((links[2].rotation.col(0) + Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((links[3].position - Vec3(1.02, 2.1, 3)).norm(), 1e-12);
  EXPECT_LT((links[3].rotation - Mat3::Identity()).norm(), 1e-12);
}

TEST(Hand, ClosingInFreeAirFollowsTheRatiosToTheLimits) {
  proto::HandBundle bundle = planar_hand();
  bundle.mutable_joint(1)->set_upper(0.4);
  bundle.mutable_motor(1)->set_ratio(0, -1);  // closes towards its lower limit
  bundle.set_preset(2, 0.03);
  const auto hand = HandModel::create(bundle);
  ASSERT_TRUE(hand) << hand.error().message;
  proto::SceneConfig scene;
  const auto world = World::create(scene, {});
  ASSERT_TRUE(world);
  PosedWorld posed;
  world->place(Placements{}, posed);
  HandState state(*hand);
  Closing closing(*hand, 1);
  state.open(*hand, Pose{Mat3::Identity(), Vec3(0, 0, 0.5)});
  closing.close(*hand, posed, 2e-4, state);
  EXPECT_EQ(state.value[0], 2);
  EXPECT_EQ(state.value[1], 0.4);
  EXPECT_EQ(state.value[2], 0) << "a negative ratio closes to the lower limit";
}

TEST(Hand, AJointStopsForItsOwnLinkAndTheOneBeyondGoesOn) {
  // A thin bar 3 mm above the first link's middle stops the first joint; the second curls on to its limit.
  proto::HandBundle bundle = planar_hand();
  const auto hand = HandModel::create(bundle);
  ASSERT_TRUE(hand);
  proto::ObjectBundle bar;
  auto* part = bar.add_part();
  part->mutable_box()->set_hx(0.001);
  part->mutable_box()->set_hy(0.05);
  part->mutable_box()->set_hz(0.001);
  bar.set_torque_scale(0.05);
  proto::SceneConfig scene;
  const auto world = World::create(scene, {bar});
  ASSERT_TRUE(world) << world.error().message;
  Placements placements;
  placements.pose = {Pose{Mat3::Identity(), Vec3(0.068, 0, 0.509)}};
  placements.resting = {0};
  placements.present = {1};
  PosedWorld posed;
  world->place(placements, posed);
  HandState state(*hand);
  Closing closing(*hand, 2);
  state.open(*hand, Pose{Mat3::Identity(), Vec3(0, 0, 0.5)});
  closing.close(*hand, posed, 2e-4, state);
  EXPECT_GT(state.value[0], 0.05);
  EXPECT_LT(state.value[0], 0.4) << "stopped by the bar";
  EXPECT_EQ(state.value[1], 2) << "goes on to its limit";
  const double gap = distance(hand->parts()[1].shape, state.part[1], posed.obstacle[1]).distance;
  EXPECT_GT(gap, 0);
  EXPECT_LE(gap, 2e-4);
}

// The bounds that continuous collision rests on, against finite differences over random configurations.
TEST(Hand, NoPointMovesFasterThanItsBound) {
  for (const std::string& name : assets::builtin_hands()) {
    const auto loaded = assets::load_hand(name, EVOGRASP_SOURCE_DIR);
    ASSERT_TRUE(loaded) << loaded.error().message;
    const auto hand = HandModel::create(loaded->bundle);
    ASSERT_TRUE(hand) << hand.error().message;
    Random random(9, Purpose::kTestHarness);
    const auto joints = hand->joints().size();
    for (int i = 0; i < 200; ++i) {
      for (const HandMotor& motor : hand->motors()) {
        const JointSet active = motor.joints & random.next();
        std::vector<double> q(joints), q0, q1;
        for (std::size_t j = 0; j < joints; ++j)
          q[j] = random.uniform(hand->joints()[j].lower, hand->joints()[j].upper);
        const double h = 1e-4;
        q0 = q1 = q;
        for (std::size_t j = 0; j < joints; ++j) {
          if (!(active >> j & 1)) continue;
          q0[j] -= h * hand->ratio(static_cast<int>(j));
          q1[j] += h * hand->ratio(static_cast<int>(j));
        }
        std::vector<Pose> before(hand->parts().size() + joints + 1), here = before, after = before;
        hand->forward(q0, Pose{}, before);
        hand->forward(q, Pose{}, here);
        hand->forward(q1, Pose{}, after);
        for (const int p : motor.part) {
          const HandPart& part = hand->parts()[static_cast<std::size_t>(p)];
          const auto l = static_cast<std::size_t>(part.link);
          const Vec3 x = part.pose * part.shape.support(testing::random_vector(random, 1));
          const auto bound = hand->motion_bound(p, active);
          const double speed = ((after[l] * x) - (before[l] * x)).norm() / (2 * h);
          const double acceleration = ((after[l] * x) - 2 * (here[l] * x) + (before[l] * x)).norm() / (h * h);
          EXPECT_LE(speed, bound.speed + 1e-6) << name << " part " << p;
          EXPECT_LE(acceleration, bound.acceleration + 1e-5) << name << " part " << p;
        }
      }
    }
  }
}

TEST(Hand, NeighboursNeverStopEachOther) {
  const auto hand = HandModel::create(planar_hand());
  ASSERT_TRUE(hand);
  EXPECT_FALSE(hand->may_collide(1, 0)) << "child and parent";
  EXPECT_FALSE(hand->may_collide(2, 1));
  EXPECT_TRUE(hand->may_collide(2, 3)) << "both moved, by different motors";
}

}  // namespace
}  // namespace evograsp::sim

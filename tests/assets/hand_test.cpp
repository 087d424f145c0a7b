// Built-in hands: counts, limits, couplings and frames.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "assets/assets.h"
#include "common/pose.h"
#include "tests/assets/files.h"

namespace evograsp::assets {
namespace {

LoadedHand load(const std::string& name) {
  Result<LoadedHand> hand = load_hand(name, {});
  EXPECT_TRUE(hand) << (hand ? "" : hand.error().message);
  return hand ? *hand : LoadedHand();
}

// Link frames in the palm frame.
std::vector<Pose> forward(const proto::HandBundle& hand, const std::vector<double>& q) {
  std::vector<Pose> frames(hand.link_size());
  for (int i = 0; i < hand.joint_size(); ++i) {
    const auto& joint = hand.joint(i);
    const Vec3 axis = from_proto(joint.axis());
    const Pose motion = joint.prismatic() ? Pose{Mat3::Identity(), q[i] * axis}
                                          : Pose{rotation_about(axis, q[i]), Vec3::Zero()};
    frames[i + 1] = frames[joint.parent_link()] * from_proto(joint.origin()) * motion;
  }
  return frames;
}

void expect_sound(const proto::HandBundle& hand) {
  ASSERT_EQ(hand.link_size(), hand.joint_size() + 1);
  ASSERT_EQ(hand.preset_size(), hand.joint_size());
  std::vector<int> drivers(hand.joint_size(), 0);
  for (const auto& motor : hand.motor()) {
    ASSERT_EQ(motor.joint_size(), motor.ratio_size());
    for (const auto joint : motor.joint()) ++drivers[joint];
  }
  for (int i = 0; i < hand.joint_size(); ++i) {
    EXPECT_LE(static_cast<int>(hand.joint(i).parent_link()), i) << "parents stand before children";
    EXPECT_NEAR(from_proto(hand.joint(i).axis()).norm(), 1, 1e-12);
    EXPECT_EQ(drivers[i], hand.joint(i).locked() ? 0 : 1) << hand.joint(i).name();
    EXPECT_GE(hand.preset(i), hand.joint(i).lower());
    EXPECT_LE(hand.preset(i), hand.joint(i).upper());
  }
}

int joint_index(const proto::HandBundle& hand, const std::string& name) {
  for (int i = 0; i < hand.joint_size(); ++i) {
    if (hand.joint(i).name() == name) return i;
  }
  ADD_FAILURE() << "no joint " << name;
  return 0;
}

TEST(Hand, EveryBuiltInIsSoundWithoutWarnings) {
  const std::vector<std::string> names = builtin_hands();
  ASSERT_EQ(names.size(), 3u);
  for (const std::string& name : names) {
    const LoadedHand hand = load(name);
    expect_sound(hand.bundle);
    EXPECT_TRUE(hand.warnings.empty()) << name << ": " << hand.warnings.front();
    for (const auto& link : hand.bundle.link()) EXPECT_GT(link.part_size(), 0) << name << " " << link.name();
  }
}

TEST(Hand, MekaHasTwelveJointsOnFiveMotorsSevenOfThemCoupled) {
  const proto::HandBundle hand = load("meka_h2").bundle;
  EXPECT_EQ(hand.joint_size(), 12);
  ASSERT_EQ(hand.motor_size(), 5);
  int coupled = 0, held = 0;
  for (const auto& motor : hand.motor()) coupled += motor.joint_size() - 1, held += motor.hold();
  EXPECT_EQ(coupled, 7);
  EXPECT_EQ(held, 1);
  EXPECT_NEAR(hand.joint(joint_index(hand, "index_joint0")).upper(), 81 * M_PI / 180, 1e-5);
  EXPECT_NEAR(hand.joint(joint_index(hand, "index_joint2")).upper(), 99 * M_PI / 180, 1e-5);
  EXPECT_NEAR(hand.joint(joint_index(hand, "thumb_rotator")).upper(), 90 * M_PI / 180, 1e-5);
  EXPECT_NEAR(hand.link(0).mass(), 0.663 + 1.2, 1e-12);  // palm and forearm, fixed together
}

TEST(Hand, MekaCapsulesAreMergedFromCylinderAndBalls) {
  const proto::HandBundle hand = load("meka_h2").bundle;
  for (int i = 1; i < hand.link_size(); ++i) {
    ASSERT_EQ(hand.link(i).part_size(), 1) << hand.link(i).name();
    EXPECT_TRUE(hand.link(i).part(0).has_capsule());
  }
}

TEST(Hand, MekaFingersCurlTowardsTheApproachAxisAndTheThumbOpposes) {
  const proto::HandBundle hand = load("meka_h2").bundle;
  std::vector<double> q(hand.preset().begin(), hand.preset().end());
  const std::vector<Pose> open = forward(hand, q);
  const int tip = joint_index(hand, "index_joint2") + 1;
  EXPECT_NEAR((open[tip] * Vec3(0.023, 0, 0) - Vec3(0.149, -0.028, 0)).norm(), 0, 1e-9);
  const Vec3 thumb = open[hand.thumb_tip_link()] * from_proto(hand.thumb_tip());
  EXPECT_GT(thumb.z(), 0.1);  // stands up
  for (const char* name : {"index_joint0", "index_joint1"}) q[joint_index(hand, name)] = 0.7;
  EXPECT_GT((forward(hand, q)[tip] * Vec3(0.023, 0, 0)).z(), 0.05);
  for (const char* name : {"thumb_joint1", "thumb_joint2"}) q[joint_index(hand, name)] = 0.7;
  const auto closed = forward(hand, q);
  EXPECT_GT((closed[hand.thumb_tip_link()] * from_proto(hand.thumb_tip())).x(), thumb.x() + 0.03);
}

TEST(Hand, JawsMeetInTheMiddle) {
  const proto::HandBundle hand = load("parallel_jaw").bundle;
  ASSERT_EQ(hand.joint_size(), 2);
  const auto closed = forward(hand, {0.05, 0.05});
  for (const Pose& jaw : {closed[1], closed[2]}) EXPECT_NEAR(jaw.position.y(), 0, 1e-12);
}

TEST(Hand, BarrettFingersCloseAgainstEachOther) {
  const proto::HandBundle hand = load("barrett").bundle;
  EXPECT_EQ(hand.joint_size(), 8);
  std::vector<double> q(8, 0.0);
  const auto tip_x = [&](const char* joint) {
    return (forward(hand, q)[joint_index(hand, joint) + 1] * Vec3(0, 0, 0.056)).x();
  };
  EXPECT_GT(tip_x("left_joint2"), 0.07);
  EXPECT_LT(tip_x("back_joint2"), -0.07);
  for (const char* name : {"left_joint1", "right_joint1", "back_joint1"}) q[joint_index(hand, name)] = 1.2;
  EXPECT_LT(tip_x("left_joint2"), 0.03);
  EXPECT_GT(tip_x("back_joint2"), -0.03);
}

TEST(Hand, RealRobotsLoadFromBareUrdfsAndAnArmIsNamedOne) {
  const std::filesystem::path data = testing::data_folder();
  if (data.empty()) return;
  struct Case {
    const char* file;
    int joints;  // 0: refused
  };
  for (const Case& c :
       {Case{"meka_dreamer/h2_hand_right_lowres.urdf", 12}, Case{"meka_dreamer/dreamer_lowres.urdf", 12},
        Case{"meka_dreamer/meka_description/robots/uta.urdf", 12},
        Case{"allegro_right/allegro_hand_description/allegro_hand_description_right.urdf", 16},
        Case{"staubli_rx160/staubli_rx160_support/urdf/rx160.urdf", 0}}) {
    const std::filesystem::path file = data / "robots" / c.file;
    const Result<LoadedHand> hand = load_hand(file.string(), {});
    if (c.joints == 0) {
      ASSERT_FALSE(hand);
      EXPECT_NE(hand.error().message.find("not a hand"), std::string::npos) << hand.error().message;
      continue;
    }
    ASSERT_TRUE(hand) << hand.error().message;
    EXPECT_EQ(hand->bundle.joint_size(), c.joints);
    EXPECT_EQ(hand->bundle.motor_size(), 4);
    EXPECT_FALSE(hand->warnings.empty()) << "guesses are told";
    expect_sound(hand->bundle);
    for (const auto& link : hand->bundle.link()) EXPECT_GT(link.part_size(), 0) << link.name();
  }
}

}  // namespace
}  // namespace evograsp::assets

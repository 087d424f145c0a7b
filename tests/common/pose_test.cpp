#include "common/pose.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "common/det_math.h"
#include "common/random.h"

namespace evograsp {
namespace {

Pose random_pose(Random& random) {
  const double ax = random.uniform(-1, 1), ay = random.uniform(-1, 1), az = random.uniform(-1, 1);
  const double angle = random.uniform(-det::kPi, det::kPi);
  const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), z = random.uniform(-1, 1);
  return {axis_angle({ax, ay, az}, angle), {x, y, z}};
}

TEST(Pose, RotationsAreOrthonormal) {
  Random random(3, Purpose::kTestHarness);
  for (int i = 0; i < 1000; ++i) {
    const Pose pose = random_pose(random);
    ASSERT_LT((pose.rotation * pose.rotation.transpose() - Mat3::Identity()).norm(), 1e-14);
    ASSERT_NEAR(pose.rotation.determinant(), 1, 1e-14);
  }
}

TEST(Pose, InverseUndoes) {
  Random random(4, Purpose::kTestHarness);
  for (int i = 0; i < 1000; ++i) {
    const Pose pose = random_pose(random);
    const Pose identity = pose * pose.inverse();
    ASSERT_LT((identity.rotation - Mat3::Identity()).norm() + identity.position.norm(), 1e-13);
  }
}

TEST(Pose, QuaternionRoundTripKeepsTheRotation) {
  Random random(5, Purpose::kTestHarness);
  for (int i = 0; i < 1000; ++i) {
    const Pose pose = random_pose(random);
    const Pose back = from_proto(to_proto(pose));
    ASSERT_LT((back.rotation - pose.rotation).norm(), 1e-13);
    ASSERT_EQ(back.position, pose.position);
  }
}

TEST(Pose, QuarterTurnAboutZTakesXToY) {
  EXPECT_LT((axis_angle({0, 0, 3}, det::kPi / 2) * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm(), 1e-15);
}

TEST(Pose, ZeroAxisMeansNoRotation) {
  EXPECT_EQ(axis_angle({0, 0, 0}, 2.0), Mat3::Identity());
}

TEST(Pose, ZeroQuaternionIsTheIdentity) {
  EXPECT_EQ(rotation_from_quaternion(0, 0, 0, 0), Mat3::Identity());
}

TEST(Pose, FiniteMeansEveryNumber) {
  Pose pose;
  EXPECT_TRUE(is_finite(pose));
  pose.rotation(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_finite(pose));
}

}  // namespace
}  // namespace evograsp

// Contact patches: how many points, where, and never off either surface.
#include "sim/patch.h"

#include <gtest/gtest.h>

#include "sim/contacts.h"
#include "tests/sim/random_shapes.h"

namespace evograsp::sim {
namespace {

constexpr double kMargin = 1e-3;

Patch patch_of(const Shape& a, const Pose& xa, const Shape& b, const Pose& xb) {
  DistanceOptions exact;
  exact.tolerance = 1e-9;
  return contact_patch(a, xa, b, xb, distance(a, xa, b, xb, exact), kMargin);
}

Pose at(double x, double y, double z) {
  return {Mat3::Identity(), Vec3(x, y, z)};
}

TEST(Patch, TwoFacesMeetInTheCornersOfTheirOverlap) {
  const Shape pad = Shape::box({0.01, 0.02, 0.005}, 0.0005), block = Shape::box({0.03, 0.03, 0.03}, 0.0005);
  const Patch p = patch_of(pad, at(0.025, 0, 0.0351), block, at(0, 0, 0));
  ASSERT_EQ(p.count, 4);
  for (int i = 0; i < 4; ++i) {
    const PatchPoint& q = p.point[static_cast<std::size_t>(i)];
    EXPECT_NEAR(q.point.z(), 0.03, 1e-9) << "on the block";
    EXPECT_NEAR(q.gap, 1e-4, 1e-9);
    EXPECT_TRUE(std::fabs(q.point.x() - 0.0155) < 1e-9 || std::fabs(q.point.x() - 0.0295) < 1e-9)
        << q.point.x();
    EXPECT_NEAR(std::fabs(q.point.y()), 0.0195, 1e-9);
  }
}

TEST(Patch, ARodOnAFaceTouchesAtItsTwoEnds) {
  const Shape rod = Shape::capsule(0.008, 0.015), block = Shape::box({0.03, 0.03, 0.03}, 0.0005);
  const Pose lying{rotation_about(Vec3::UnitY(), 1.5707963267948966), Vec3(0, 0, 0.0382)};
  const Patch p = patch_of(rod, lying, block, at(0, 0, 0));
  ASSERT_EQ(p.count, 2);
  EXPECT_NEAR(std::fabs(p.point[0].point.x()), 0.015, 1e-6);
  EXPECT_NEAR(p.point[0].point.x(), -p.point[1].point.x(), 1e-6);
}

TEST(Patch, RoundThingsTouchInOnePoint) {
  const Shape rod = Shape::capsule(0.008, 0.015), ball = Shape::ball(0.03);
  EXPECT_EQ(patch_of(rod, at(0.0381, 0, 0), ball, at(0, 0, 0)).count, 1);
  const Pose crossed{rotation_about(Vec3::UnitX(), 1.5707963267948966), Vec3(0.0161, 0, 0)};
  EXPECT_EQ(patch_of(rod, crossed, rod, at(0, 0, 0)).count, 1) << "crossed rods";
}

TEST(Patch, ATiltBeyondTheMarginLeavesAnEdgeOrACorner) {
  const Shape pad = Shape::box({0.01, 0.01, 0.005}, 0.0005), block = Shape::box({0.03, 0.03, 0.03}, 0.0005);
  const Pose edge{rotation_about(Vec3::UnitX(), 0.2), Vec3(0, 0, 0.0372)};
  EXPECT_EQ(patch_of(pad, edge, block, at(0, 0, 0)).count, 2);
  const Pose corner{rotation_about(Vec3(0.6, 0.8, 0), 0.3), Vec3(0, 0, 0.0385)};
  EXPECT_EQ(patch_of(pad, corner, block, at(0, 0, 0)).count, 1);
}

TEST(Patch, PointsLieOnTheTargetWithinTheMarginOfBoth) {
  Random random(11, Purpose::kTestHarness);
  int many = 0;
  const Shape dot = Shape::ball(0);
  for (int i = 0; i < 20000; ++i) {
    const Shape a = testing::random_shape(random, i % 5), b = testing::random_shape(random, i / 5 % 5);
    // Half of the pairs have their axes aligned, so that faces really meet faces.
    Pose xa = testing::random_pose(random, 0.01);
    const Pose xb = testing::random_pose(random, 0.01);
    if (i % 2) xa.rotation = xb.rotation;
    const Separation far = distance(a, xa, b, xb);
    if (far.overlap) continue;
    xa.position += (random.uniform(1e-4, 9e-4) - far.distance) * far.normal;
    const Separation s = distance(a, xa, b, xb);
    if (s.overlap || s.distance > kMargin || s.distance <= 0) continue;
    const Patch p = contact_patch(a, xa, b, xb, s, kMargin);
    ASSERT_GE(p.count, 1);
    many += p.count > 1;
    for (int k = 0; k < p.count; ++k) {
      const PatchPoint& q = p.point[static_cast<std::size_t>(k)];
      ASSERT_LE(q.gap, kMargin + 1e-9);
      const double off_b = distance(dot, {Mat3::Identity(), q.point}, b, xb).distance;
      const double off_a = distance(dot, {Mat3::Identity(), q.point}, a, xa).distance;
      ASSERT_LT(std::fabs(off_b), 1.1e-3) << "pair " << i;
      ASSERT_LT(off_a, 2.2e-3) << "pair " << i;
    }
  }
  EXPECT_GT(many, 500);
}

// Two halves of one block: a pad that rests on the left half near the seam must not feel the right half's
// edge.
TEST(Contacts, SeamsBetweenConvexPartsGiveNoSidewaysNormals) {
  proto::HandBundle bundle;
  auto* palm = bundle.add_link();
  auto* tip = palm->add_part();
  tip->mutable_ball()->set_radius(0.008);
  const auto hand = HandModel::create(bundle);
  ASSERT_TRUE(hand) << hand.error().message;
  proto::ObjectBundle block;
  for (const double x : {-0.02, 0.02}) {
    auto* part = block.add_part();
    part->mutable_box()->set_hx(0.02);
    part->mutable_box()->set_hy(0.03);
    part->mutable_box()->set_hz(0.03);
    part->set_rounding(0);
    part->mutable_pose()->mutable_position()->set_x(x);
  }
  block.set_torque_scale(0.05);
  const auto world = World::create(proto::SceneConfig(), {block});
  ASSERT_TRUE(world) << world.error().message;
  Placements placements;
  placements.pose = {at(0, 0, 0.1)};
  placements.resting = {0};
  placements.present = {1};
  PosedWorld posed;
  world->place(placements, posed);
  HandState state(*hand);
  std::vector<Contact> contacts;
  for (const double x : {-0.0005, -0.0001, 0.0, 0.0001, 0.0005}) {
    state.open(*hand, at(x, 0, 0.1381));
    collect_contacts(*hand, state, posed, 0, kMargin, contacts);
    ASSERT_GE(contacts.size(), 1u) << "at " << x;
    for (const Contact& c : contacts) EXPECT_LT((c.normal + Vec3::UnitZ()).norm(), 0.02) << "at " << x;
  }
}

}  // namespace
}  // namespace evograsp::sim

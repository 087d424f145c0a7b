// Stable faces against cases whose answer is known by hand, and against Bullet, which drops the hull and
// waits.
#include "assets/resting.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "common/det_math.h"
#include "common/random.h"

namespace evograsp::assets {
namespace {

std::vector<Vec3> cuboid(double x, double y, double z, const Vec3& centre = Vec3::Zero()) {
  std::vector<Vec3> out;
  for (int i = 0; i < 8; ++i)
    out.push_back(centre + Vec3(i & 1 ? x / 2 : -x / 2, i & 2 ? y / 2 : -y / 2, i & 4 ? z / 2 : -z / 2));
  return out;
}

double share_of(const std::vector<RestingFace>& faces, const Vec3& down) {
  for (const RestingFace& face : faces)
    if (face.down.dot(down) > 0.9999) return face.share;
  return 0;
}

TEST(RestingFaces, ACubeRestsOnEachSideAlike) {
  const auto faces = resting_faces(cuboid(0.06, 0.06, 0.06), Vec3::Zero());
  ASSERT_EQ(faces.size(), 6u);
  for (const RestingFace& face : faces) {
    EXPECT_NEAR(face.share, 1.0 / 6, 1e-9);
    EXPECT_NEAR(face.down.cwiseAbs().maxCoeff(), 1, 1e-9) << "a side, not an edge";
  }
}

// The solid angle of a rectangle 2a x 2b at distance d: 4 atan(a b / (d sqrt(a^2 + b^2 + d^2))).
TEST(RestingFaces, ACuboidPrefersItsLargeSidesByTheirSolidAngle) {
  const auto faces = resting_faces(cuboid(0.10, 0.06, 0.02), Vec3::Zero());
  ASSERT_EQ(faces.size(), 6u);
  const auto expected = [](double a, double b, double d) {
    return std::atan(a * b / (d * std::sqrt(a * a + b * b + d * d))) / det::kPi;
  };
  EXPECT_NEAR(share_of(faces, Vec3(0, 0, 1)), expected(0.05, 0.03, 0.01), 1e-9);
  EXPECT_NEAR(share_of(faces, Vec3(0, -1, 0)), expected(0.05, 0.01, 0.03), 1e-9);
  EXPECT_NEAR(share_of(faces, Vec3(1, 0, 0)), expected(0.03, 0.01, 0.05), 1e-9);
  EXPECT_NEAR(std::fabs(faces[1].down.z()), 1, 1e-9) << "the likeliest after the one as modelled";
}

// A prism that leans so far that its centre is beyond its foot falls over.
TEST(RestingFaces, ALeaningPrismDoesNotStandOnItsFoot) {
  const auto prism = [](double lean) {
    std::vector<Vec3> out = cuboid(0.03, 0.03, 0.10);
    for (Vec3& p : out) p.x() += lean * p.z();
    return out;
  };
  EXPECT_GT(share_of(resting_faces(prism(0.2), Vec3::Zero()), Vec3(0, 0, -1)), 0.0);
  EXPECT_EQ(share_of(resting_faces(prism(0.4), Vec3::Zero()), Vec3(0, 0, -1)), 0.0)
      << "0.05 x 0.4 is past 0.015";
}

TEST(RestingFaces, AWeightedCuboidStandsOnItsHeavySide) {
  const auto faces = resting_faces(cuboid(0.05, 0.05, 0.05), Vec3(0, 0, -0.02));
  EXPECT_EQ(faces.front().down.z(), -1) << "what is near the centre fills more of its view";
  EXPECT_GT(faces.front().share, 0.4);
}

TEST(RestingFaces, ACylindersSideIsAFewFacesAndABallHasAtLeastOne) {
  std::vector<Vec3> can, ball;
  for (int i = 0; i < 48; ++i) {
    const double a = 2 * det::kPi * i / 48;
    for (const double z : {-0.05, 0.05}) can.emplace_back(0.03 * det::cos(a), 0.03 * det::sin(a), z);
  }
  Random random(1, Purpose::kTestHarness);
  while (ball.size() < 500) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), z = random.uniform(-1, 1);
    const Vec3 p(x, y, z);
    if (p.norm() < 1 && p.norm() > 0.1) ball.push_back(0.04 * p / p.norm());
  }
  const auto faces = resting_faces(can, Vec3::Zero());
  EXPECT_EQ(faces.size(), 6u) << "at most";
  EXPECT_NEAR(faces.front().down.z(), -1, 1e-9) << "as modelled comes first";
  // The solid angle of a disc of radius r at distance d: 2 pi (1 - d / sqrt(r^2 + d^2)).
  EXPECT_NEAR(faces.front().share, (1 - 0.05 / std::sqrt(0.0034)) / 2, 0.001);
  EXPECT_FALSE(resting_faces(ball, Vec3::Zero()).empty());
}

TEST(RestingFaces, NothingForFlatSetsAndCentresOutside) {
  EXPECT_TRUE(resting_faces({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, Vec3::Zero()).empty());
  EXPECT_TRUE(resting_faces(cuboid(0.1, 0.1, 0), Vec3::Zero()).empty());
  EXPECT_TRUE(resting_faces(cuboid(0.1, 0.1, 0.1), Vec3(0, 0, 0.2)).empty());
}

// The direction that points down once the hull, laid on the table with `down` down and tilted, has come to
// rest.
Vec3 dropped(const std::vector<Vec3>& points, const Vec3& down, double tilt) {
  btConvexHullShape shape;
  shape.setMargin(0.0002);
  for (const Vec3& p : points) shape.addPoint({p.x(), p.y(), p.z()}, false);
  shape.recalcLocalAabb();
  btBoxShape table({1, 1, 0.1});
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, -9.81});
  btVector3 inertia;
  shape.calculateLocalInertia(0.3, inertia);
  btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &table, {0, 0, 0}));
  btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(0.3, nullptr, &shape, inertia));
  ground.setWorldTransform(btTransform(btQuaternion::getIdentity(), {0, 0, -0.1}));
  double lowest = -1;
  for (const Vec3& p : points) lowest = std::max(lowest, down.dot(p));
  btQuaternion turn = shortestArcQuat(btVector3(down.x(), down.y(), down.z()), btVector3(0, 0, -1));
  turn = btQuaternion(btVector3(1, 0, 0), tilt) * turn;
  body.setWorldTransform(btTransform(turn, {0, 0, lowest + 0.002}));
  for (btRigidBody* b : {&ground, &body}) b->setFriction(1), b->setRestitution(0), world.addRigidBody(b);
  body.setDamping(0.2, 0.4);
  for (int i = 0; i < 480; ++i) world.stepSimulation(1.0 / 240, 0);
  const btVector3 d = body.getWorldTransform().getBasis().inverse() * btVector3(0, 0, -1);
  world.removeRigidBody(&body), world.removeRigidBody(&ground);
  return {d.x(), d.y(), d.z()};
}

TEST(RestingFaces, BulletKeepsThemAndLeavesTheOthers) {
  Random random(4, Purpose::kTestHarness);
  int stable = 0, kept = 0;
  for (int shape = 0; shape < 12; ++shape) {
    std::vector<Vec3> points;
    for (int i = 0; i < 10; ++i) {
      const double x = random.uniform(-0.05, 0.05), y = random.uniform(-0.04, 0.04);
      const double z = random.uniform(-0.03, 0.03);
      points.emplace_back(x, y, z);
    }
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : points) mean += p / 10;
    for (Vec3& p : points) p -= mean;
    for (const RestingFace& face : resting_faces(points, Vec3::Zero())) {
      ++stable;
      kept += dropped(points, face.down, 0.01).dot(face.down) > 0.99 ? 1 : 0;
    }
    // From any side it ends on a stable one (or on one too unlikely to be listed).
    const Vec3 end = dropped(points, Vec3(0.6, 0, 0.8), 0);
    double nearest = -1;
    for (const RestingFace& face : resting_faces(points, Vec3::Zero(), 100))
      nearest = std::max(nearest, face.down.dot(end));
    EXPECT_GT(nearest, 0.9) << "shape " << shape;
  }
  EXPECT_GT(stable, 25);
  EXPECT_GE(kept, stable * 9 / 10) << "of " << stable;
  std::printf("Bullet keeps %d of %d resting faces\n", kept, stable);
}

}  // namespace
}  // namespace evograsp::assets

// Pair distances against Bullet's double-precision detector, and against the certificate that every answer
// carries: a direction that separates the shapes by as much as the two witness points are apart proves both.
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "sim/gjk.h"
#include "tests/sim/random_shapes.h"

namespace evograsp::sim {
namespace {

using testing::random_pose;
using testing::random_shape;

std::unique_ptr<btConvexShape> to_bullet(const Shape& s) {
  const Vec3 outer = s.half + Vec3::Constant(s.sweep);
  std::unique_ptr<btConvexShape> out;
  switch (s.core) {
    case Core::kPoint:
      return std::make_unique<btSphereShape>(s.sweep);
    case Core::kSegment:
      return std::make_unique<btCapsuleShapeZ>(s.sweep, 2 * s.half.z());
    case Core::kBox:
      out = std::make_unique<btBoxShape>(btVector3(outer.x(), outer.y(), outer.z()));
      break;
    case Core::kDisc:
      out = std::make_unique<btCylinderShapeZ>(btVector3(outer.x(), outer.y(), outer.z()));
      break;
    case Core::kHull: {
      auto hull = std::make_unique<btConvexHullShape>();
      for (std::size_t i = 0; i < s.x.size(); ++i) hull->addPoint(btVector3(s.x[i], s.y[i], s.z[i]));
      out = std::move(hull);
    }
  }
  out->setMargin(s.sweep);
  return out;
}

btTransform to_bullet(const Pose& x) {
  const Mat3& r = x.rotation;
  return btTransform(
      btMatrix3x3(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)),
      btVector3(x.position.x(), x.position.y(), x.position.z()));
}

double bullet_distance(const btConvexShape& a, const Pose& xa, const btConvexShape& b, const Pose& xb) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver penetration;
  btGjkPairDetector detector(&a, &b, &simplex, &penetration);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = to_bullet(xa);
  input.m_transformB = to_bullet(xb);
  btPointCollector result;
  detector.getClosestPoints(input, result, nullptr);
  return result.m_hasResult ? result.m_distance : BT_LARGE_FLOAT;
}

// Bullet's other solver, of the cores; only where they are apart.
double bullet_core_distance(const btConvexShape& a, const Pose& xa, const btConvexShape& b, const Pose& xb) {
  btGjkEpaSolver2::sResults result;
  const btTransform ta = to_bullet(xa), tb = to_bullet(xb);
  if (!btGjkEpaSolver2::Distance(&a, ta, &b, tb, tb.getOrigin() - ta.getOrigin(), result))
    return BT_LARGE_FLOAT;
  return (result.witnesses[0] - result.witnesses[1]).length();
}

double extent(const Shape& s, const Pose& x, const Vec3& direction) {
  return direction.dot(x * s.support(x.rotation.transpose() * direction)) + s.sweep;
}

// Pairs whose cores meet have no distance to compare: they come on top.
TEST(Distance, EqualsBulletAndCarriesItsProofOn100000RandomPairs) {
  Random random(1, Purpose::kTestHarness);
  int apart = 0, shallow = 0, doubted = 0;
  double worst = 0, worst_proof = 0;
  for (int i = 0; apart + shallow < 100000; ++i) {
    ASSERT_LT(i, 200000) << "too many pairs whose cores meet";
    const Shape a = random_shape(random, i % 5), b = random_shape(random, i / 5 % 5);
    const Pose xa = random_pose(random, 0.01);
    Pose xb = random_pose(random, 0.01);
    // One statement a draw: compilers order the operands of a product as they like.
    const double share = random.uniform(0.2, 1.5);
    const Vec3 way = random_pose(random, 0).rotation.col(0);
    xb.position += share * (a.radius + b.radius) * way;
    const Separation s = distance(a, xa, b, xb);
    const auto ba = to_bullet(a), bb = to_bullet(b);
    const double reference = bullet_distance(*ba, xa, *bb, xb);
    if (s.overlap) {
      // Cores meet: Bullet must see the shapes at least as deep as the swept layers. Its growing polytope
      // stops early inside some cylinders, at less depth: there its second solver must find the cores met.
      if (!(reference < -(a.sweep + b.sweep) + 1e-4)) {
        ++doubted;
        EXPECT_TRUE(a.core == Core::kDisc || b.core == Core::kDisc) << "pair " << i;
        EXPECT_EQ(bullet_core_distance(*ba, xa, *bb, xb), BT_LARGE_FLOAT) << "pair " << i;
      }
      continue;
    }
    (s.distance > 0 ? apart : shallow) += 1;
    const double separation = -extent(a, xa, -s.normal) - extent(b, xb, s.normal);
    const double proof =
        std::max(std::fabs(separation - s.distance), std::fabs((s.on_a - s.on_b).dot(s.normal) - s.distance));
    worst_proof = std::max(worst_proof, proof);
    ASSERT_LT(proof, 2e-7) << "pair " << i;
    // Bullet's pair detector gives up early on some pairs of cylinders (always above the truth, by up to
    // 0.3 mm): these are held against its second solver.
    double error = std::fabs(s.distance - reference);
    if (error > 1e-4) {
      ++doubted;
      EXPECT_TRUE(a.core == Core::kDisc || b.core == Core::kDisc) << "pair " << i;
      EXPECT_GT(reference, s.distance) << "pair " << i;
      error = std::fabs(s.distance - (bullet_core_distance(*ba, xa, *bb, xb) - a.sweep - b.sweep));
    }
    worst = std::max(worst, error);
    ASSERT_LT(error, 1e-4) << "pair " << i << " kinds " << i % 5 << ", " << i / 5 % 5;
  }
  EXPECT_GT(apart, 50000);
  EXPECT_GT(shallow, 1000);
  EXPECT_LT(doubted, 200);
  std::printf(
      "%d apart, %d shallow; worst difference to Bullet %.2g m, worst gap of proof %.2g m, %d by the second "
      "solver\n",
      apart, shallow, worst, worst_proof, doubted);
}

}  // namespace
}  // namespace evograsp::sim

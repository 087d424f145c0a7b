// Rays against references that share no code with them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "scene_objects.h"
#include "sim/ray_caster.h"

namespace evograsp::sim {
namespace {

Ray random_ray(Random& random) {
  const Vec3 from = testing::random_vector(random, 1);
  const Vec3 at = testing::random_vector(random, 0.08);
  const double stretch = random.uniform(0.5, 1.5);
  return {Vec3(from.normalized() * 0.7), Vec3((at - from.normalized() * 0.7) * stretch)};
}

// Signed distance bounds of the same shapes: the reference walks along the ray by sphere tracing.
double distance_to(const proto::ObjectBundle& object, const Vec3& p) {
  const proto::ConvexPart& part = object.part(0);
  if (part.has_ball()) return p.norm() - part.ball().radius();
  if (part.has_capsule()) {
    const double z = std::clamp(p.z(), -part.capsule().half_length(), part.capsule().half_length());
    return (p - Vec3(0, 0, z)).norm() - part.capsule().radius();
  }
  if (part.has_cylinder()) {
    const double side = std::hypot(p.x(), p.y()) - part.cylinder().radius();
    const double cap = std::fabs(p.z()) - part.cylinder().half_length();
    return std::min(std::max(side, cap), 0.0) + std::hypot(std::max(side, 0.0), std::max(cap, 0.0));
  }
  Vec3 half(0.03, 0.05, 0.02);
  const Vec3 q = p.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}

TEST(Solid, EntersWhereSphereTracingDoes) {
  Random random(11, Purpose::kTestHarness);
  int hits = 0, rays = 0;
  double worst = 0;  // m
  for (const proto::ObjectBundle& object :
       {testing::box(0.03, 0.05, 0.02), testing::ball(0.04), testing::cylinder(0.03, 0.06),
        testing::capsule(0.02, 0.04), testing::hull_box(0.03, 0.05, 0.02)}) {
    const Solid solid = *Solid::create(object.part(0));
    for (int i = 0; i < 4000; ++i) {
      const Ray ray = random_ray(random);
      const double speed = ray.direction.norm();
      double t = 0, closest = 1;
      bool reached = false;
      for (int step = 0; step < 3000 && t * speed < 2 && !reached; ++step) {
        const double d = distance_to(object, ray.at(t));
        closest = std::min(closest, d);
        reached = d < 1e-9;
        t += d / speed;
      }
      if (!reached && closest < 1e-6) continue;  // grazing: either answer is right
      double at = 0;
      ++rays;
      ASSERT_EQ(solid.enter(ray, 0, 100, &at), reached) << object.name() << " ray " << i;
      if (reached) {
        EXPECT_NEAR(at * speed, t * speed, 1e-5) << object.name();
        worst = std::max(worst, std::fabs(at - t) * speed);
      }
      hits += reached;
    }
  }
  EXPECT_GT(hits, rays / 4);
  std::printf("%d rays, %d hit; worst difference of depth %.2g m\n", rays, hits, worst);
}

TEST(Solid, NormalIsTheGradientOfTheDistance) {
  Random random(12, Purpose::kTestHarness);
  for (const proto::ObjectBundle& object :
       {testing::box(0.03, 0.05, 0.02), testing::ball(0.04), testing::cylinder(0.03, 0.06),
        testing::capsule(0.02, 0.04), testing::hull_box(0.03, 0.05, 0.02)}) {
    const Solid solid = *Solid::create(object.part(0));
    for (int i = 0; i < 500; ++i) {
      const Ray ray = random_ray(random);
      double at = 0;
      if (!solid.enter(ray, 0, 100, &at)) continue;
      const Vec3 p = ray.at(at), n = solid.normal(p);
      EXPECT_NEAR(distance_to(object, p + 1e-4 * n), 1e-4, 2e-6) << object.name();
      EXPECT_LT(n.dot(ray.direction), 0) << object.name();
    }
  }
}

TEST(Solid, RefusesShapesThatAreNone) {
  proto::ConvexPart part;
  EXPECT_FALSE(Solid::create(part));
  part.mutable_box()->set_hx(1);
  EXPECT_FALSE(Solid::create(part));
  part.mutable_ball()->set_radius(std::nan(""));
  EXPECT_FALSE(Solid::create(part));
  for (int i = 0; i < 12; ++i) part.mutable_hull()->add_xyz(i == 7 ? std::nan("") : i * i * 0.01);
  EXPECT_FALSE(Solid::create(part)) << "a hull with a vertex nowhere";
  part.mutable_hull()->clear_xyz();
  EXPECT_FALSE(Solid::create(part)) << "a hull of no vertex";
}

TEST(TriangleMesh, EqualsAScanOfEveryTriangleBitForBit) {
  const proto::ObjectBundle object = testing::rippled(0.05, 50, 100);
  const auto mesh = *TriangleMesh::create(object.visual());
  ASSERT_EQ(mesh->size(), 10000u);
  Random random(5, Purpose::kTestHarness);
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    Ray ray = random_ray(random);
    if (i % 3 == 0) {  // through a vertex exactly: up to six triangles meet at one depth
      const int v = 3 * static_cast<int>(random.below(5000));
      const Vec3 corner(object.visual().xyz(v), object.visual().xyz(v + 1), object.visual().xyz(v + 2));
      ray.direction = corner - ray.origin;
    }
    double a = 10, b = 10;
    const int tree = mesh->enter(ray, 0, &a);
    const int scan = mesh->enter_by_scan(ray, 0, &b);
    ASSERT_EQ(tree, scan) << i;
    ASSERT_EQ(a, b) << i;
    hits += tree >= 0;
  }
  EXPECT_GT(hits, 1000);
}

TEST(TriangleMesh, NoRaySlipsBetweenNeighbours) {
  const auto mesh = *TriangleMesh::create(testing::rippled(0.05, 30, 60).visual());
  const proto::ObjectBundle object = testing::rippled(0.05, 30, 60);
  Random random(6, Purpose::kTestHarness);
  for (int i = 0; i < 20000; ++i) {
    const int f = 3 * static_cast<int>(random.below(static_cast<std::uint32_t>(mesh->size())));
    const auto vertex = [&](int k) {
      const int v = 3 * static_cast<int>(object.visual().triangle(f + k));
      return Vec3(object.visual().xyz(v), object.visual().xyz(v + 1), object.visual().xyz(v + 2));
    };
    const Vec3 on_edge = vertex(0) + random.uniform() * (vertex(1) - vertex(0));
    // From near the centre no edge is a silhouette: a ray that slips through meets nothing or something
    // beyond.
    const Vec3 eye = testing::random_vector(random, 1e-5);
    double t = 10;
    ASSERT_GE(mesh->enter({eye, on_edge - eye}, 0, &t), 0) << i;
    EXPECT_LE(t, 1 + 1e-9) << i;
  }
}

TEST(TriangleMesh, RefusesBrokenMeshes) {
  proto::TriangleMesh mesh;
  EXPECT_FALSE(TriangleMesh::create(mesh));
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) mesh.add_xyz(x);
  for (const std::uint32_t v : {0u, 1u, 3u}) mesh.add_triangle(v);
  EXPECT_FALSE(TriangleMesh::create(mesh)) << "an index out of range";
  mesh.set_triangle(2, 2);
  EXPECT_TRUE(TriangleMesh::create(mesh));
  mesh.set_xyz(4, std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(TriangleMesh::create(mesh));
}

TEST(PosedScene, ReportsTheNearestOfTableAndBodies) {
  auto bodies = std::make_shared<std::vector<RayBody>>();
  bodies->push_back(*RayBody::create(testing::ball(0.04)));
  bodies->push_back(*RayBody::create(testing::rippled(0.03, 20, 40)));
  const RayCaster caster(bodies, 0.5);
  const std::vector<Pose> poses = {{Mat3::Identity(), Vec3(0, 0, 0.04)},
                                   {Mat3::Identity(), Vec3(0.2, 0, 0.03)}};
  const PosedScene scene(caster, poses, {});
  const auto down = [&](double x) { return scene.cast({Vec3(x, 0, 1), Vec3(0, 0, -1)}, 0, 5); };
  EXPECT_EQ(down(0).body, 0);
  EXPECT_NEAR(down(0).t, 0.92, 1e-12);
  EXPECT_EQ(down(0.2).body, 1);
  EXPECT_EQ(down(0.4).body, kTable);
  EXPECT_DOUBLE_EQ(down(0.4).t, 1);
  EXPECT_EQ(down(0.6).body, kNothing);
  EXPECT_LT((scene.normal({Vec3(0, 0, 1), Vec3(0, 0, -1)}, down(0)) - Vec3(0, 0, 1)).norm(), 1e-9);
  const std::vector<std::uint8_t> only_second = {0, 1};
  EXPECT_EQ(PosedScene(caster, poses, only_second).cast({Vec3(0, 0, 1), Vec3(0, 0, -1)}, 0, 5).body, kTable);
}

}  // namespace
}  // namespace evograsp::sim

// Meshes: cleaning, orientation, mass properties, hulls, simplification.
#include "assets/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "assets/hollow.h"
#include "assets/hull.h"
#include "assets/meshgen.h"
#include "assets/parts.h"
#include "assets/simplify.h"
#include "common/random.h"
#include "tests/assets/files.h"

namespace evograsp::assets {
namespace {

using testing::box_mesh;
using testing::lathe_mesh;

Mesh sphere_mesh(double radius, int steps) {
  std::vector<ProfilePoint> profile;
  for (int i = 0; i <= steps; ++i) {
    const double a = M_PI * i / steps;
    profile.push_back({i == 0 || i == steps ? 0 : radius * std::sin(a), -radius * std::cos(a)});
  }
  return lathe_mesh(profile, 2 * steps);
}

TEST(Mesh, BoxHasTheFormulasMassProperties) {
  Mesh mesh = box_mesh({0.02, 0.03, 0.05});
  const Vec3 moved(0.1, -0.2, 0.3);
  for (Vec3& v : mesh.vertices) v += moved;
  const Solid got = solid_of(mesh), want = solid_box(0.04, 0.06, 0.1);
  EXPECT_NEAR(got.volume, want.volume, 1e-15);
  EXPECT_LT((got.centre - moved).norm(), 1e-14);
  EXPECT_LT((got.inertia - want.inertia).norm(), 1e-12 * want.inertia.norm());
}

TEST(Mesh, FineSphereApproachesTheFormula) {
  const Mesh mesh = sphere_mesh(0.04, 64);
  EXPECT_EQ(open_edges(mesh), 0u);
  const Solid got = solid_of(mesh), want = solid_sphere(0.04);
  EXPECT_NEAR(got.volume / want.volume, 1, 2e-3);
  EXPECT_NEAR(got.inertia(0, 0) / want.inertia(0, 0), 1, 4e-3);
  EXPECT_NEAR(area_of(mesh), 4 * M_PI * 0.04 * 0.04, 1e-4 * 0.16);
}

TEST(Mesh, WeldJoinsATriangleSoupAndDropsWhatHasNoArea) {
  const Mesh box = box_mesh({0.01, 0.01, 0.01});
  Mesh soup;
  for (std::size_t t = 0; t < box.triangles.size(); ++t) {
    const auto base = static_cast<std::uint32_t>(soup.vertices.size());
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(box.corner(t, k));
    soup.triangles.push_back({base, base + 1, base + 2});
  }
  soup.triangles.push_back({0, 0, 1});  // degenerate
  soup.triangles.push_back({1, 2, 0});  // the first one again, turned
  weld(soup, 1e-7);
  EXPECT_EQ(soup.vertices.size(), 8u);
  EXPECT_EQ(soup.triangles.size(), 12u);
  EXPECT_EQ(open_edges(soup), 0u);
}

TEST(Mesh, OrientationIsRepairedWhateverTheTrianglesTurn) {
  Random random(1, Purpose::kTestHarness);
  const Mesh box = box_mesh({0.01, 0.02, 0.03});
  for (int round = 0; round < 20; ++round) {
    Mesh mesh = box;
    for (auto& t : mesh.triangles) {
      if (random.chance(0.5)) std::swap(t[0], t[1]);
    }
    orient_outward(mesh);
    EXPECT_EQ(open_edges(mesh), 0u);
    EXPECT_NEAR(solid_of(mesh).volume, 8 * 6e-6, 1e-12);
  }
}

TEST(Mesh, ACavityStaysACavityAndASecondShellTurnsOutward) {
  Mesh mesh = box_mesh({0.05, 0.05, 0.05});
  const auto add = [&](const Mesh& other, const Vec3& at, bool inward) {
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Vec3& v : other.vertices) mesh.vertices.push_back(v + at);
    for (auto t : other.triangles) {
      if (inward) std::swap(t[0], t[1]);
      mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    }
  };
  add(box_mesh({0.02, 0.02, 0.02}), Vec3::Zero(), true);
  add(box_mesh({0.01, 0.01, 0.01}), Vec3(0.2, 0, 0), true);
  orient_outward(mesh);
  EXPECT_NEAR(solid_of(mesh).volume, 1e-3 - 6.4e-5 + 8e-6, 1e-12);
}

TEST(Mesh, ARemovedTriangleOpensThreeEdges) {
  Mesh mesh = box_mesh({0.01, 0.01, 0.01});
  mesh.triangles.pop_back();
  EXPECT_EQ(open_edges(mesh), 3u);
}

TEST(Mesh, EncodingComesBackAndDamageIsRefused) {
  const Mesh mesh = sphere_mesh(0.03, 8);
  const std::string bytes = encode(mesh);
  const Result<Mesh> back = decode(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(encode(*back), bytes);
  EXPECT_FALSE(decode(std::string_view(bytes).substr(0, bytes.size() - 1)));
  EXPECT_FALSE(decode(std::string_view(bytes).substr(0, 10)));
  std::string wild = bytes;
  wild[wild.size() - 1] = '\x7f';  // an index far out of range
  EXPECT_FALSE(decode(wild));
}

TEST(Hull, HoldsEveryPointAndOnlyInputPoints) {
  Random random(2, Purpose::kTestHarness);
  for (int round = 0; round < 50; ++round) {
    std::vector<Vec3> points;
    for (int i = 0; i < 60; ++i) {
      const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), z = random.uniform(-1, 1);
      points.emplace_back(0.05 * x, 0.03 * y, round % 3 == 0 ? 1e-4 * z : 0.04 * z);
    }
    const ConvexHull hull = convex_hull(points);
    for (const Vec3& p : points) EXPECT_LE(hull.distance(p), 2e-5);  // Bullet's grid
    for (const Vec3& v : hull.vertices) EXPECT_NE(std::find(points.begin(), points.end(), v), points.end());
  }
}

TEST(Hull, BoxHasItsVolumeAreaAndWidth) {
  const ConvexHull hull = convex_hull(box_mesh({0.01, 0.02, 0.03}).vertices);
  EXPECT_NEAR(hull.solid.volume, 4.8e-5, 1e-15);
  EXPECT_NEAR(hull.area, 8 * (0.0002 + 0.0003 + 0.0006), 1e-12);
  EXPECT_NEAR(hull.width, 0.02, 1e-12);
}

TEST(Hull, DegeneratePointSetsHaveNoVolumeAndDoNoHarm) {
  const Vec3 p(0.01, 0.02, 0.03);
  for (const std::vector<Vec3>& points : {std::vector<Vec3>{},
                                          {p},
                                          {p, p, p},
                                          {p, 2 * p},
                                          {p, 2 * p, 3 * p},
                                          {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)}}) {
    EXPECT_EQ(convex_hull(points).solid.volume, 0);
  }
}

TEST(Hull, ReducedHullsStayWithinTheirTolerance) {
  const ConvexHull hull = convex_hull(sphere_mesh(0.03, 24).vertices);
  const std::vector<Vec3> few = reduced_hull(hull, 400, 5e-4);
  EXPECT_LT(few.size(), hull.vertices.size() / 2);
  const ConvexHull sketch = convex_hull(few);
  for (const Vec3& v : hull.vertices) EXPECT_LE(sketch.distance(v), 5.1e-4);
  EXPECT_LE(reduced_hull(hull, 20, 0).size(), 20u);
}

TEST(Hull, PartsHaveTheHullsOuterSurface) {
  const Mesh box = box_mesh({0.02, 0.03, 0.01});
  const proto::ConvexPart part = part_from_points(box.vertices, 32, kRounding);
  EXPECT_DOUBLE_EQ(part.rounding(), kRounding);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(support(part, Vec3::Unit(k)), Vec3(0.02, 0.03, 0.01)[k], 1e-6);
    EXPECT_NEAR(support(part, -Vec3::Unit(k)), Vec3(0.02, 0.03, 0.01)[k], 1e-6);
  }
}

TEST(Simplify, KeepsClosednessAndVolume) {
  const Mesh fine = sphere_mesh(0.05, 40);
  const Mesh coarse = simplified(fine, 600);
  EXPECT_LE(coarse.triangles.size(), 600u);
  EXPECT_GT(coarse.triangles.size(), 400u);
  EXPECT_EQ(open_edges(coarse), 0u);
  EXPECT_NEAR(solid_of(coarse).volume / solid_of(fine).volume, 1, 0.01);
}

TEST(Simplify, KeepsThinWallsApart) {
  const Mesh cup = lathe_mesh(
      {{0, 0}, {0.04, 0}, {0.04, 0.05}, {0.04, 0.1}, {0.037, 0.1}, {0.037, 0.05}, {0.037, 0.003}, {0, 0.003}},
      96);
  const Mesh coarse = simplified(cup, 300);
  EXPECT_LE(coarse.triangles.size(), 300u);
  EXPECT_NEAR(solid_of(coarse).volume / solid_of(cup).volume, 1, 0.1);
}

TEST(Simplify, ASmallMeshIsLeftAlone) {
  const Mesh box = box_mesh({0.01, 0.01, 0.01});
  EXPECT_EQ(encode(simplified(box, 100)), encode(box));
}

TEST(Hollow, ACupsHollowIsFoundAndABoxHasNone) {
  const Mesh box = box_mesh({0.03, 0.03, 0.03});
  EXPECT_TRUE(hollow_points(box, convex_hull(box.vertices), 0.002, 4000).empty());
  const Mesh cup = lathe_mesh({{0, 0}, {0.04, 0}, {0.04, 0.1}, {0.036, 0.1}, {0.036, 0.004}, {0, 0.004}}, 32);
  const std::vector<Vec3> hollow = hollow_points(cup, convex_hull(cup.vertices), 0.002, 4000);
  EXPECT_GT(hollow.size(), 1500u);
  for (const Vec3& p : hollow) {
    EXPECT_LT(p.head<2>().norm(), 0.0345);
    EXPECT_GT(p.z(), 0.0055);
  }
}

TEST(Meshgen, ShippedFilesAreWhatTheGeneratorWrites) {
  for (const auto& [name, text] : {std::pair{"bottle", bottle_obj()}, std::pair{"cup", handled_cup_obj()}}) {
    std::ifstream in(std::filesystem::path(EVOGRASP_SOURCE_DIR) / "configs/objects" /
                     (std::string(name) + ".obj"));
    const std::string shipped((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    EXPECT_EQ(shipped, text) << name << ": run evograsp-meshgen " << name << " > configs/objects/" << name
                             << ".obj";
  }
}

}  // namespace
}  // namespace evograsp::assets

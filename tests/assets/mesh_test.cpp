// Meshes: cleaning, orientation, mass properties, hulls, simplification.
#include "assets/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "assets/hollow.h"
#include "assets/hull.h"
#include "assets/mesh_import.h"
#include "assets/meshgen.h"
#include "assets/parts.h"
#include "assets/ply.h"
#include "assets/polygon.h"
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

TEST(Solid, OnlyWhatABodyCanHaveIsABody) {
  EXPECT_TRUE(solid_box(0.1, 0.1, 0.1).is_body());
  EXPECT_TRUE(solid_box(1, 1, 1e-5).is_body());
  EXPECT_FALSE(Solid().is_body());
  const auto with = [](const Vec3& moments) {
    Solid s{1, Vec3::Zero(), Mat3::Zero()};
    s.inertia.diagonal() = moments;
    return s.is_body();
  };
  EXPECT_TRUE(with({3, 4, 5}));
  EXPECT_FALSE(with({1, 1, 2.1})) << "more than the other two together";
  EXPECT_FALSE(with({1, 1, 2})) << "flat";
  EXPECT_FALSE(with({1, 1, -1}));
  EXPECT_FALSE(with({-1, -1, -1}));
  EXPECT_FALSE(with({1, 1, std::nan("")}));
  Solid turned = solid_box(0.1, 0.2, 0.3);
  turned.inertia(0, 1) = turned.inertia(1, 0) = 2 * turned.inertia(2, 2);
  EXPECT_FALSE(turned.is_body()) << "products as large are of no body";
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

// A ten-thousandth as thick as long, askew: every face is a sliver, whose normal means nothing.
std::vector<Vec3> needle() {
  const Vec3 along(0.3, 0.4, 0.5), aside(4e-5, -3e-5, 0), up(0, 5e-5, -4e-5);
  return {Vec3::Zero(), along, along / 2 + aside, along / 2 + up};
}

TEST(Hull, ANeedleIsThin) {
  ASSERT_GT(convex_hull(needle()).solid.volume, 0) << "flat: this is no case";
  EXPECT_EQ(convex_hull(needle()).width, 0);
  const proto::ConvexPart part = part_from_points(needle(), 32, kRounding);
  EXPECT_LE(part.rounding(), 5e-5) << "it grew by the rounding of a thick part";
  Mesh mesh{needle(), {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
  EXPECT_TRUE(hollow_points(mesh, convex_hull(mesh.vertices), 0.002, 1000).empty()) << "the box it lies in";
}

TEST(Hull, PointsOnALineMakeAPartOfNoMoreCornersThanAllowed) {
  std::vector<Vec3> points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(1e-4 * i, 0, 0);
  const proto::ConvexPart part = part_from_points(points, 32, kRounding);
  EXPECT_LE(part.hull().xyz_size(), 3 * 32);
  EXPECT_NEAR(support(part, Vec3::UnitX()), 0.0999, 1e-4);
  EXPECT_NEAR(support(part, -Vec3::UnitX()), 0, 1e-4);
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

// Each format's file of a box gives the box.
TEST(MeshImport, EveryFormatHoldsTheSameBox) {
  const Mesh box = box_mesh({0.02, 0.03, 0.05});
  std::string solid = testing::binary_stl_of(box);
  solid.replace(0, 5, "solid");
  std::string crlf = testing::ply_of(box);
  for (std::size_t at = 0; (at = crlf.find('\n', at)) != std::string::npos; at += 2) crlf.insert(at, "\r");
  std::string ascii = "solid box\n";
  for (std::size_t t = 0; t < box.triangles.size(); ++t) {
    ascii += "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) {
      ascii += "vertex";
      for (int c = 0; c < 3; ++c) ascii += " " + std::to_string(box.corner(t, k)[c]);
      ascii += "\n";
    }
    ascii += "endloop\nendfacet\n";
  }
  std::string bare = testing::obj_of(box);  // 0.02 as .02, -0.02 as -.02
  for (std::size_t at = 0; (at = bare.find("0.", at)) != std::string::npos;) bare.erase(at, 1);
  const std::pair<const char*, std::string> files[] = {
      {"box.obj", testing::obj_of(box)},
      {"bare.obj", bare},
      {"box.stl", testing::binary_stl_of(box)},
      {"solid.stl", solid},
      {"longer.stl", testing::binary_stl_of(box) + "made by somebody"},
      {"ascii.stl", ascii + "endsolid box\n"},
      {"box.ply", testing::ply_of(box)},
      {"crlf.ply", crlf},
      {"little.ply", testing::binary_ply_of(box, false)},
      {"big.ply", testing::binary_ply_of(box, true)},
      {"box.glb", testing::glb_of(box)},
      {"box.dae", testing::dae_of(box)},
  };
  for (const auto& [name, bytes] : files) {
    const Result<Mesh> mesh = import_mesh_bytes(bytes, name, 1);
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_EQ(mesh->vertices.size(), 8u) << name;
    EXPECT_EQ(mesh->triangles.size(), 12u) << name;
    EXPECT_EQ(open_edges(*mesh), 0u) << name;
    EXPECT_NEAR(solid_of(*mesh).volume, 2.4e-4, 1e-9) << name;
  }
}

TEST(Ply, ReadsEveryTypeAndReadsOverWhatItDoesNotKnow) {
  const Result<Mesh> mesh = read_ply(
      "ply\r\nformat ascii 1.0\r\ncomment element face 9\r\nelement fan 2\r\nproperty list char short "
      "blade\r\n"
      "property double pitch\r\nelement vertex 4\r\nproperty uchar red\r\nproperty int16 z\r\nproperty "
      "double y\r\n"
      "property float32 x\r\nelement face 2\r\nproperty uint8 flag\r\nproperty list uint16 uint32 "
      "vertex_index\r\n"
      "end_header\r\n2 5 6 0.5\r\n0 1\r\n255 3 2e-1 +.5\r\n0 0 0 0\r\n0 0 1 0\r\n0 0 0 1\r\n1 3 1 2 3\r\n0 2 "
      "0 1\r\n");
  ASSERT_TRUE(mesh) << mesh.error().message;
  ASSERT_EQ(mesh->vertices.size(), 4u);
  EXPECT_EQ(mesh->vertices[0], Vec3(0.5, 0.2, 3));
  EXPECT_EQ(mesh->vertices[3], Vec3(1, 0, 0));
  ASSERT_EQ(mesh->triangles.size(), 1u) << "two corners are no face";
  EXPECT_EQ(mesh->triangles[0], (std::array<std::uint32_t, 3>{1, 2, 3}));
}

// A whole file, whose first number begins with the byte of a line feed.
TEST(Ply, ABinaryBodyMayBeginWithALineFeed) {
  Mesh box = box_mesh({0.02, 0.02, 0.02});
  box.vertices[0].x() = std::bit_cast<float>(0xbca3d70au);
  const std::string bytes = testing::binary_ply_of(box, false);
  ASSERT_EQ(bytes[bytes.find("end_header\n") + 11], '\n');
  const Result<Mesh> mesh = import_mesh_bytes(bytes, "feed.ply", 1);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->triangles.size(), 12u);
}

double area_inside(const std::vector<Vec3>& outline) {
  Mesh mesh;
  std::vector<std::uint32_t> corners(outline.size());
  std::iota(corners.begin(), corners.end(), 0);
  mesh.vertices = outline;
  add_polygon(corners, mesh);
  EXPECT_EQ(mesh.triangles.size(), outline.size() - 2);
  const Vec3 up = (mesh.corner(0, 1) - mesh.corner(0, 0)).cross(mesh.corner(0, 2) - mesh.corner(0, 0));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    EXPECT_GE(n.dot(up), 0) << "triangle " << t << " is turned over";
  }
  return area_of(mesh);
}

// Triangles that overlap or stick out would have too much area.
TEST(Polygon, ConcaveOnesAreCutIntoTheirArea) {
  const std::vector<Vec3> arrow = {{0, 0, 0}, {2, -1, 0}, {0, 2, 0}, {-2, -1, 0}};
  EXPECT_NEAR(area_inside(arrow), 4, 1e-12);
  std::vector<Vec3> comb;  // ten teeth, 1 x 1 each, on a back of 19 x 1
  for (int tooth = 0; tooth < 10; ++tooth) {
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(1, 0, 0)})
      comb.push_back(p + Vec3(2 * tooth, 0, 0));
  }
  comb.emplace_back(19, 0, -1);
  comb.emplace_back(0, 0, -1);
  EXPECT_NEAR(area_inside(comb), 29, 1e-12);
  std::reverse(comb.begin(), comb.end());
  EXPECT_NEAR(area_inside(comb), 29, 1e-12);
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

// Files from strangers: each gives an error that names the file and the reason, and leaves the process well.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "assets/assets.h"
#include "assets/contained.h"
#include "assets/mesh_import.h"
#include "assets/parts.h"
#include "assets/ply.h"
#include "assets/simplify.h"
#include "common/random.h"
#include "tests/assets/files.h"

namespace evograsp::assets {
namespace {

using testing::binary_stl_of;
using testing::box_mesh;
using testing::obj_of;
using testing::ply_of;
using testing::TemporaryFolder;

class Hostile : public ::testing::Test {
 protected:
  // The error of loading bytes under a name; it must name the file and hold `reason`.
  void expect_refused(const std::string& name, const std::string& bytes, const std::string& reason) {
    const std::string path = folder_.write(name, bytes);
    const Result<LoadedObject> object = load_object(path, {1, 0, {}, folder_.path() / "cache"});
    ASSERT_FALSE(object) << name << " was accepted";
    EXPECT_NE(object.error().message.find(name), std::string::npos) << object.error().message;
    EXPECT_NE(object.error().message.find(reason), std::string::npos) << object.error().message;
  }
  TemporaryFolder folder_;
};

TEST_F(Hostile, EmptyFilesOfEveryFormat) {
  for (const char* name : {"a.obj", "a.stl", "a.ply", "a.dae", "a.gltf", "a.glb"})
    expect_refused(name, "", "empty");
}

TEST_F(Hostile, GarbageOfEveryFormat) {
  Random random(1, Purpose::kTestHarness);
  std::string garbage;
  for (int i = 0; i < 5000; ++i) garbage.push_back(static_cast<char>(random.next()));
  for (const char* name : {"g.obj", "g.stl", "g.ply", "g.dae", "g.gltf", "g.glb"})
    expect_refused(name, garbage, "");
}

TEST_F(Hostile, TruncatedFiles) {
  const Mesh box = box_mesh({0.02, 0.02, 0.02});
  const std::string stl = binary_stl_of(box);
  expect_refused("cut.stl", stl.substr(0, stl.size() - 75), "announces 12 triangles, only 10");
  std::string solid = stl.substr(0, stl.size() - 75);
  solid.replace(0, 5, "solid");
  expect_refused("solid.stl", solid, "announces 12 triangles, only 10");
  expect_refused("ascii.stl", "solid box\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "cut short");
  const std::string obj = obj_of(box);
  expect_refused("cut.obj", obj.substr(0, obj.size() - 3), "its last face has 2 corners");
  expect_refused("half.obj", obj.substr(0, obj.size() / 2), "");
  const std::string dae = testing::dae_of(box);
  expect_refused("cut.dae", dae.substr(0, dae.size() - 20), "malformed XML");
  const std::string glb = testing::glb_of(box);
  expect_refused("cut.glb", glb.substr(0, glb.size() - 1), "cut short");
  expect_refused("head.glb", glb.substr(0, 19), "cut short");
  const std::string gltf = testing::gltf_of(box);
  expect_refused("cut.gltf", gltf.substr(0, gltf.size() - 1), "cut short");
}

// Wherever a PLY file of any kind is cut before its last number, it says so.
TEST_F(Hostile, PlyCutAnywhere) {
  const Mesh box = box_mesh({0.02, 0.02, 0.02});
  const std::string whole[] = {ply_of(box), testing::binary_ply_of(box, false),
                               testing::binary_ply_of(box, true)};
  for (const std::string& ply : whole) {
    ASSERT_TRUE(import_mesh_bytes(ply, "box.ply", 1)) << import_mesh_bytes(ply, "box.ply", 1).error().message;
    for (std::size_t size = 4; size + 2 < ply.size(); ++size) {
      const Result<Mesh> mesh = read_ply(std::string_view(ply).substr(0, size));
      ASSERT_FALSE(mesh) << "cut at " << size << " of " << ply.size();
      const std::string& why = mesh.error().message;
      ASSERT_NE(why.find("cut short"), std::string::npos) << "cut at " << size << ": " << why;
    }
  }
  expect_refused("ascii.ply", whole[0].substr(0, whole[0].size() - 25), "announces 12 of 'face', only 9");
  expect_refused("binary.ply", whole[1].substr(0, whole[1].size() - 20), "announces 12 of 'face', only 10");
}

TEST_F(Hostile, PlyThatLies) {
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string points = "0 0 0\n0.1 0 0\n0 0.1 0\n", z = "property float z\n";
  expect_refused("two.ply", head + faces, "no x, y and z");
  expect_refused("index.ply", head + z + faces + points + "3 0 1 3\n", "face 1 names vertex 3 of 3");
  expect_refused("minus.ply", head + z + faces + points + "3 0 1 -1\n", "no index");
  expect_refused("half.ply", head + z + faces + points + "3 0 1 1.5\n", "no index");
  expect_refused("long.ply", head + z + faces + points + "-3 0 1 2\n", "no whole length");
  expect_refused("many.ply", head + z + faces + points + "1001 0 1 2\n", "more than 1000 corners");
  expect_refused("word.ply", head + z + faces + "0 0 zero\n", "'vertex' 1 holds something that is no number");
  expect_refused("type.ply", head + "property quad z\n" + faces, "unknown type");
  expect_refused("line.ply", head + "colour red\n", "unknown header line 'colour'");
  expect_refused("format.ply", "ply\nformat binary_middle_endian 1.0\nend_header\n", "unknown format");
  expect_refused("none.ply", "plywood\n", "no PLY file");
}

TEST_F(Hostile, LimitsOfSize) {
  const std::string large = folder_.write("large.stl", "solid");
  std::filesystem::resize_file(large, kMaxMeshFile + 1);
  const Result<LoadedObject> object = load_object(large, {});
  ASSERT_FALSE(object);
  EXPECT_NE(object.error().message.find("large.stl: larger than"), std::string::npos)
      << object.error().message;

  const std::string vertices = std::to_string(kMaxMeshVertices + 1), x = "property float x\n";
  const std::string triangles = std::to_string(kMaxMeshTriangles + 1);
  expect_refused("vertices.ply", "ply\nformat ascii 1.0\nelement vertex " + vertices + "\n" + x,
                 "more than 2000000 vertices");
  expect_refused("faces.ply", "ply\nformat ascii 1.0\nelement face " + triangles + "\n" + x,
                 "more than 1000000 triangles");
  std::string obj = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\n";
  for (std::size_t i = 0; i <= kMaxMeshTriangles; ++i) obj += "f 1 2 3\n";
  expect_refused("triangles.obj", obj, "1000000 triangles");
  // A small file: each of 90,000 nodes shows the same 12 triangles.
  std::string nodes = R"([{"mesh":0,"children":[1)";
  for (int i = 2; i < 90000; ++i) nodes += "," + std::to_string(i);
  nodes += "]}";
  for (int i = 1; i < 90000; ++i) nodes += R"(,{"mesh":0})";
  expect_refused("instances.glb", testing::glb_of(box_mesh({0.02, 0.02, 0.02}), nodes + "]"),
                 "1000000 triangles");
}

// Thirty nodes, each of which shows the next one twice, are 2^30 boxes.
TEST_F(Hostile, NodesThatMultiply) {
  const Mesh box = box_mesh({0.02, 0.02, 0.02});
  std::string nodes = "[";
  for (int i = 1; i <= 30; ++i)
    nodes += R"({"children":[)" + std::to_string(i) + "," + std::to_string(i) + "]},";
  nodes += R"({"mesh":0}])";
  const auto began = std::chrono::steady_clock::now();
  expect_refused("many.glb", testing::glb_of(box, nodes), "node 1 has two parents");
  expect_refused("many.gltf", testing::gltf_of(box, nodes), "node 1 has two parents");
  expect_refused("circle.glb", testing::glb_of(box, R"([{"mesh":0,"children":[0]}])"),
                 "root and another's child");
  expect_refused("nobody.glb", testing::glb_of(box, R"([{"mesh":0,"children":[7]}])"), "does not exist");
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(5)) << "refused, but slowly";
}

TEST_F(Hostile, NotFiniteVertices) {
  Mesh box = box_mesh({0.02, 0.02, 0.02});
  box.vertices[3].x() = NAN;
  expect_refused("nan.stl", binary_stl_of(box), "not finite");
  box.vertices[3].x() = INFINITY;
  expect_refused("inf.stl", binary_stl_of(box), "not finite");
  expect_refused("inf.ply", testing::binary_ply_of(box, false), "not finite");
  expect_refused("far.ply", testing::binary_ply_of(box, true), "not finite");
}

TEST_F(Hostile, WrongUnitsAreNamed) {
  expect_refused("huge.stl", binary_stl_of(box_mesh({20, 30, 40})), "0.001 for millimetres");
  expect_refused("tiny.stl", binary_stl_of(box_mesh({2e-5, 3e-5, 4e-5})), "too small");
}

TEST_F(Hostile, NoTrianglesNoAreaNoVolume) {
  expect_refused("points.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\n", "");
  expect_refused("line.obj", "v 0 0 0\nv 0.1 0 0\nv 0.2 0 0\nf 1 2 3\n", "no triangle has an area");
  expect_refused("flat.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0.1 0.1 0\nf 1 2 3\nf 2 4 3\n", "no volume");
}

TEST_F(Hostile, CountsThatLie) {
  std::string stl = binary_stl_of(box_mesh({0.02, 0.02, 0.02}));
  for (int i = 80; i < 84; ++i) stl[static_cast<std::size_t>(i)] = '\xff';
  expect_refused("count.stl", stl, "cut short");
  expect_refused("count.ply",
                 "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
                 "property float y\nproperty float z\nelement face 4000000000\n"
                 "property list uchar int vertex_indices\nend_header\n1234",
                 "");
  expect_refused("index.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 999999999\n", "");
}

TEST_F(Hostile, DeeplyNestedDocuments) {
  std::string xml = "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\">";
  for (int i = 0; i < 200000; ++i) xml += "<node>";
  expect_refused("deep.dae", xml, "");
  expect_refused("deep.gltf", std::string(500000, '['), "");
}

TEST_F(Hostile, OtherFilesAreNotReadThroughAMesh) {
  TemporaryFolder elsewhere;
  const std::string secret = elsewhere.write("secret.bin", std::string(72, '\0'));
  const std::string gltf =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"uri":")" +
      secret + R"(","byteLength":72}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":72}],
"accessors":[{"bufferView":0,"componentType":5126,"count":6,"type":"VEC3"}]})";
  expect_refused("outside.gltf", gltf, "");
  std::filesystem::create_symlink(secret, folder_.path() / "link.bin");
  std::string linked = gltf;
  linked.replace(linked.find(secret), secret.size(), "link.bin");
  expect_refused("linked.gltf", linked, "");
}

TEST_F(Hostile, FoldersDevicesAndMissingFiles) {
  std::filesystem::create_directory(folder_.path() / "dir.stl");
  EXPECT_FALSE(load_object((folder_.path() / "dir.stl").string(), {}));
  EXPECT_FALSE(load_object((folder_.path() / "none.stl").string(), {}));
  EXPECT_FALSE(load_object("/dev/zero", {}));
  EXPECT_FALSE(load_object("", {}));
  expect_refused("what.blend", "BLENDER", "");
}

TEST_F(Hostile, RandomDamageNeverHarmsTheProcess) {
  Random random(7, Purpose::kTestHarness);
  const Mesh box = box_mesh({0.02, 0.03, 0.04});
  for (int round = 0; round < 60; ++round) {
    const int kind = round % 3;
    std::string bytes = kind == 0 ? binary_stl_of(box) : kind == 1 ? obj_of(box) : ply_of(box);
    for (int hits = 0; hits < 8; ++hits) {
      const std::uint32_t at = random.below(static_cast<std::uint32_t>(bytes.size()));
      bytes[at] = static_cast<char>(random.next());
    }
    const Result<Mesh> mesh = import_mesh_bytes(bytes,
                                                kind == 0   ? "d.stl"
                                                : kind == 1 ? "d.obj"
                                                            : "d.ply",
                                                1);
    EXPECT_TRUE(mesh || mesh.error().message.find("d.") != std::string::npos);
  }
}

// Pages bound at one edge: simplifying them takes the square of their number.
TEST_F(Hostile, SurfacesThatTakeForEverAreGivenUp) {
  Mesh book;
  book.vertices = {{0, 0, 0}, {0, 0, 0.1}};
  constexpr std::uint32_t kPages = 100'000;
  for (std::uint32_t i = 0; i < kPages; ++i) {
    const double a = i * (6.28 / kPages);
    book.vertices.emplace_back(0.1 * std::cos(a), 0.1 * std::sin(a), 0.05 + 0.02 * std::sin(7 * a));
    book.triangles.push_back({0, 1, i + 2});
  }
  const Result<Mesh> thinner = contained_simplified(book, 1200, 1);
  ASSERT_FALSE(thinner);
  EXPECT_NE(thinner.error().message.find("simplifying its surface took longer than 1 s"), std::string::npos)
      << thinner.error().message;
}

TEST_F(Hostile, ObjectFilesSayWhereTheyAreWrong) {
  expect_refused("syntax.txtpb", "cylinder { radius: }", ":1:");
  expect_refused("range.txtpb", "cylinder { radius: -1 height: 0.1 }", "radius");
  expect_refused("none.txtpb", "name: \"x\"", "no shape");
  expect_refused("thick.txtpb", "mug { outer_radius: 0.03 inner_radius: 0.04 }", "inner_radius");
  expect_refused("nowhere.txtpb", "mesh { file: \"missing.stl\" }", "");
  expect_refused("rest.txtpb", "sphere { radius: 0.03 } resting_down { x: 0 y: 0 z: 0 }", "resting_down");
  expect_refused("nan.txtpb", "sphere { radius: 0.03 } resting_down { z: nan }", "resting_down");
}

// The square of -1e200 is infinite, and a part of infinity is nothing.
TEST_F(Hostile, DirectionsOfAnyLengthAreDirections) {
  const auto rest = [&](const std::string& z) {
    const std::string path = folder_.write("tipped.txtpb",
                                           "cuboid { x: 0.1 y: 0.06 z: 0.04 } "
                                           "resting_down { x: " +
                                               z + " }");
    const Result<LoadedObject> object = load_object(path, {});
    EXPECT_TRUE(object) << (object ? "" : object.error().message);
    return object ? object->bundle.resting(0) : proto::RestingPose();
  };
  const proto::RestingPose usual = rest("-1");
  EXPECT_NEAR(usual.height(), 0.05, 1e-12);
  for (const char* z : {"-1e9", "-1e-8"}) {
    EXPECT_NEAR(rest(z).height(), 0.05, 1e-12) << z;
    EXPECT_NEAR(rest(z).orientation().w(), usual.orientation().w(), 1e-12) << z;
  }
  for (const double length : {1e-8, 1.0, 1e99, 1e101, 1e200, 1.7e308}) {
    const auto down = direction_of({0.6 * length, 0, -0.8 * length});
    ASSERT_TRUE(down) << length;
    EXPECT_LT((*down - Vec3(0.6, 0, -0.8)).norm(), 1e-15) << length;
  }
  EXPECT_FALSE(direction_of(Vec3::Zero()));
  EXPECT_FALSE(direction_of({0, 1e-10, 0}));
  EXPECT_FALSE(direction_of({HUGE_VAL, 0, 1}));
  EXPECT_FALSE(direction_of({0, NAN, 1}));
}

}  // namespace
}  // namespace evograsp::assets

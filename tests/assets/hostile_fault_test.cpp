// Files from strangers: each gives an error that names the file and the reason, and leaves the process well.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>

#include "assets/assets.h"
#include "assets/contained.h"
#include "assets/mesh_import.h"
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
  void expect_hand_refused(const std::string& name, const std::string& text, const std::string& reason) {
    const std::string path = folder_.write(name, text);
    const Result<LoadedHand> hand = load_hand(path, {});
    ASSERT_FALSE(hand) << name << " was accepted";
    EXPECT_NE(hand.error().message.find(name.substr(0, name.find('.'))), std::string::npos)
        << hand.error().message;
    EXPECT_NE(hand.error().message.find(reason), std::string::npos) << hand.error().message;
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
  expect_refused("cut.stl", stl.substr(0, stl.size() - 75), "cut short");
  const std::string ply = ply_of(box);
  expect_refused("header.ply", ply.substr(0, 40), "");
}

TEST_F(Hostile, NotFiniteVertices) {
  Mesh box = box_mesh({0.02, 0.02, 0.02});
  box.vertices[3].x() = NAN;
  expect_refused("nan.stl", binary_stl_of(box), "not finite");
  box.vertices[3].x() = INFINITY;
  expect_refused("inf.stl", binary_stl_of(box), "not finite");
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
  for (int round = 0; round < 43; ++round) {
    // Few PLY files: assimp's reader runs in circles on most of them, until its second is up.
    const int kind = round < 20 ? 0 : round < 40 ? 1 : 2;
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

TEST_F(Hostile, ObjectFilesSayWhereTheyAreWrong) {
  expect_refused("syntax.txtpb", "cylinder { radius: }", ":1:");
  expect_refused("range.txtpb", "cylinder { radius: -1 height: 0.1 }", "radius");
  expect_refused("none.txtpb", "name: \"x\"", "no shape");
  expect_refused("thick.txtpb", "mug { outer_radius: 0.03 inner_radius: 0.04 }", "inner_radius");
  expect_refused("nowhere.txtpb", "mesh { file: \"missing.stl\" }", "");
  expect_refused("rest.txtpb", "sphere { radius: 0.03 } resting_down { x: 0 y: 0 z: 0 }", "resting_down");
}

TEST_F(Hostile, UrdfsThatAreNoHands) {
  expect_hand_refused("junk.urdf", "not xml at all", "not a usable URDF");
  expect_hand_refused("empty_robot.urdf", "<robot name=\"x\"></robot>", "not a usable URDF");
  expect_hand_refused("arm.urdf",
                      R"(<robot name="arm"><link name="a"/><link name="b"/><joint name="j" type="revolute">
<parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>)",
                      "not a hand");
  std::string deep = "<robot name=\"x\">";
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  expect_hand_refused("deep.urdf", deep, "nested deeper");
  expect_hand_refused("nolimit.urdf",
                      R"(<robot name="x"><link name="a"/><link name="b"/><joint name="j" type="revolute">
<parent link="a"/><child link="b"/></joint></robot>)",
                      "");
}

const char kTwoJaws[] =
    R"(<robot name="jaws"><link name="p"><collision><geometry><box size="0.1 0.1 0.02"/></geometry></collision></link>
<link name="l"><collision><geometry><box size="0.02 0.01 0.06"/></geometry></collision></link>
<link name="r"><collision><geometry><mesh filename="%MESH%"/></geometry></collision></link>
<joint name="jl" type="prismatic"><parent link="p"/><child link="l"/><origin xyz="0 0.05 0.03"/><axis xyz="0 -1 0"/>
<limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>
<joint name="jr" type="prismatic"><parent link="p"/><child link="r"/><origin xyz="0 -0.05 0.03"/><axis xyz="0 1 0"/>
<limit lower="0" upper="0.04" effort="1" velocity="1"/><mimic joint="jl" multiplier="0.5"/></joint></robot>)";

std::string jaws_with(const std::string& mesh) {
  std::string text = kTwoJaws;
  text.replace(text.find("%MESH%"), 6, mesh);
  return text;
}

TEST_F(Hostile, HandMeshesOutsideTheirPackageAreLeftOutWithAWarning) {
  for (const char* mesh :
       {"package://../../etc/passwd", "package://a/../../x.stl", "http://host/x.stl", "missing.stl"}) {
    const Result<LoadedHand> hand = load_hand(folder_.write("jaws.urdf", jaws_with(mesh)), {});
    ASSERT_TRUE(hand) << hand.error().message;
    const auto& w = hand->warnings;
    EXPECT_TRUE(std::any_of(w.begin(), w.end(), [](const auto& s) {
      return s.find("link 'r'") != std::string::npos;
    })) << mesh;
  }
}

TEST_F(Hostile, MimicJointsFollowTheirLeadersMotorAndMeshesBecomeHulls) {
  folder_.write("meshes/jaw.stl", binary_stl_of(box_mesh({10, 5, 30})));
  std::string text = jaws_with("package://meshes/jaw.stl\" scale=\"0.001 0.001 0.001");
  const Result<LoadedHand> hand = load_hand(folder_.write("jaws.urdf", text), {});
  ASSERT_TRUE(hand) << hand.error().message;
  ASSERT_EQ(hand->bundle.motor_size(), 1);
  ASSERT_EQ(hand->bundle.motor(0).joint_size(), 2);
  EXPECT_DOUBLE_EQ(hand->bundle.motor(0).ratio(0), 1);
  EXPECT_DOUBLE_EQ(hand->bundle.motor(0).ratio(1), 0.5);
  ASSERT_EQ(hand->bundle.link(2).part_size(), 1);
  EXPECT_EQ(hand->bundle.link(2).part(0).hull().xyz_size(), 24);
}

TEST_F(Hostile, HandFilesSayWhichFieldIsWrong) {
  folder_.write("jaws.urdf", jaws_with("none.stl"));
  const std::string good = "urdf: \"jaws.urdf\" palm_link: \"p\" thumb_tip_link: \"r\" ";
  expect_hand_refused("palm.txtpb", "urdf: \"jaws.urdf\" palm_link: \"q\" thumb_tip_link: \"r\"",
                      "palm_link");
  expect_hand_refused("axis.txtpb", good + "approach_axis { }", "approach_axis");
  expect_hand_refused("preset.txtpb", good + "preset { joint: \"jl\" value: 3 }", "outside the limits");
  expect_hand_refused("motor.txtpb", good + "motor { name: \"m\" joint { joint: \"zz\" } }", "zz");
  expect_hand_refused(
      "twice.txtpb",
      good + "motor { name: \"m\" joint { joint: \"jl\" } } motor { name: \"n\" joint { joint: \"jl\" } }",
      "twice");
  expect_hand_refused("thumb.txtpb", "urdf: \"jaws.urdf\" palm_link: \"p\" thumb_tip_link: \"t\"",
                      "thumb_tip_link");
  expect_hand_refused("urdf.txtpb", "palm_link: \"p\"", "urdf");
}

TEST(Contained, CrashesHangsAndGreedBecomeErrors) {
  Containment limits;
  limits.seconds = 1;
  limits.memory = std::size_t{256} << 20;
  limits.answer = 1 << 20;
  const auto run = [&](const auto& work) {
    return run_contained([&]() -> Result<std::string> { return work(); }, limits);
  };
  EXPECT_EQ(run([] { return std::string("fine"); }).value(), "fine");
  const auto crash = run([] {
    std::raise(SIGSEGV);
    return std::string();
  });
  ASSERT_FALSE(crash);
  EXPECT_NE(crash.error().message.find("signal 11"), std::string::npos) << crash.error().message;
  const auto hang = run([] {
    volatile unsigned spin = 0;
    while (true) spin = spin + 1;
    return std::string();
  });
  ASSERT_FALSE(hang);
  EXPECT_NE(hang.error().message.find("longer than 1 s"), std::string::npos) << hang.error().message;
  const auto thrown = run([]() -> std::string { throw std::runtime_error("no good"); });
  ASSERT_FALSE(thrown);
  EXPECT_EQ(thrown.error().message, "no good");
  EXPECT_FALSE(run([] { return std::string(2 << 20, 'x'); })) << "answer too long";
}

}  // namespace
}  // namespace evograsp::assets

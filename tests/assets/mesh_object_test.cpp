// Mesh files as objects: formats, frames, hollows, warnings, cache.
#include <gtest/gtest.h>

#include <cmath>

#include "assets/assets.h"
#include "assets/decompose.h"
#include "assets/mesh_import.h"
#include "assets/part_cache.h"
#include "tests/assets/files.h"

namespace evograsp::assets {
namespace {

using testing::binary_stl_of;
using testing::box_mesh;
using testing::lathe_mesh;
using testing::obj_of;
using testing::ply_of;
using testing::TemporaryFolder;

// Distance of p from the nearest part (negative: inside), by separating planes in sampled directions: never
// too large.
double clearance(const std::vector<proto::ConvexPart>& parts, const Vec3& p) {
  constexpr int kRings = 30;
  double least = 1;
  for (const proto::ConvexPart& part : parts) {
    std::vector<Vec3> core;
    for (int i = 0; i + 2 < part.hull().xyz_size(); i += 3) {
      core.push_back(from_proto(part.pose()) *
                     Vec3(part.hull().xyz(i), part.hull().xyz(i + 1), part.hull().xyz(i + 2)));
    }
    double most = -1;
    for (int i = 0; i <= kRings; ++i) {
      for (int j = 0; j < 2 * kRings; ++j) {
        const double polar = M_PI * i / kRings, turn = M_PI * j / kRings;
        const Vec3 d(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
        double reach = -1;
        for (const Vec3& v : core) reach = std::max(reach, d.dot(v));
        most = std::max(most, d.dot(p) - reach);
      }
    }
    least = std::min(least, most - part.rounding());
  }
  return least;
}

class MeshObject : public ::testing::Test {
 protected:
  Result<LoadedObject> load(const std::string& name, double scale = 1, double mass = 0) const {
    return load_object(name, {scale, mass, folder_.path(), folder_.path() / "cache"});
  }
  TemporaryFolder folder_;
};

TEST_F(MeshObject, EveryFormatGivesTheSameBox) {
  const Mesh box = box_mesh({0.02, 0.03, 0.04});
  folder_.write("box.obj", obj_of(box));
  folder_.write("box.ply", ply_of(box));
  folder_.write("box.stl", binary_stl_of(box));
  for (const char* name : {"box.obj", "box.ply", "box.stl"}) {
    const Result<LoadedObject> object = load(name);
    ASSERT_TRUE(object) << object.error().message;
    EXPECT_TRUE(object->warnings.empty()) << name << ": " << object->warnings.front();
    EXPECT_EQ(object->bundle.name(), "box");
    EXPECT_EQ(object->bundle.source(), name);
    ASSERT_EQ(object->bundle.part_size(), 1);
    EXPECT_NEAR(object->bundle.mass(), 400 * 0.04 * 0.06 * 0.08, 1e-7);
    EXPECT_NEAR(object->bundle.resting(0).height(), 0.04, 1e-5);
    EXPECT_NEAR(object->bundle.torque_scale(), std::sqrt(0.0029), 5e-4);
  }
}

TEST_F(MeshObject, ColladaAndGltfStandWithTheirUpAxisOnZ) {
  folder_.write(
      "box.dae",
      R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 0.1 0 0 0 0.2 0 0 0 0.05</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)");
  folder_.write("box.gltf",
                R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"buffers":[{"uri":"box.bin","byteLength":72}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[0.1,0.2,0.05]},
{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})");
  const float xyz[] = {0, 0, 0, 0.1f, 0, 0, 0, 0.2f, 0, 0, 0, 0.05f};
  const std::uint16_t index[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  folder_.write("box.bin", std::string(reinterpret_cast<const char*>(xyz), sizeof xyz) +
                               std::string(reinterpret_cast<const char*>(index), sizeof index));
  for (const char* name : {"box.dae", "box.gltf"}) {
    const Result<Mesh> mesh = import_mesh(folder_.path() / name, 1);
    ASSERT_TRUE(mesh) << mesh.error().message;
    const Vec3 extent = bounds_of(*mesh).extent();
    EXPECT_NEAR(extent.x(), 0.1, 1e-6) << name;
    EXPECT_NEAR(extent.y(), 0.05, 1e-6) << name;
    EXPECT_NEAR(extent.z(), 0.2, 1e-6) << name;
    EXPECT_EQ(open_edges(*mesh), 0u);
    EXPECT_NEAR(solid_of(*mesh).volume, 0.1 * 0.2 * 0.05 / 6, 1e-9);
  }
}

TEST_F(MeshObject, ScaleAndMassAreTakenFromTheOptionsOrTheObjectFile) {
  folder_.write("mm.stl", binary_stl_of(box_mesh({20, 30, 40})));
  const Result<LoadedObject> bare = load("mm.stl", 0.001, 0.7);
  ASSERT_TRUE(bare) << bare.error().message;
  EXPECT_DOUBLE_EQ(bare->bundle.mass(), 0.7);
  EXPECT_NEAR(bare->bundle.resting(0).height(), 0.04, 1e-5);
  folder_.write(
      "thing.txtpb",
      "mesh { file: \"mm.stl\" scale: 0.001 } density: 1000 material: \"wood\" resting_down { x: 1 }");
  const Result<LoadedObject> file = load("thing.txtpb");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->bundle.name(), "thing");
  EXPECT_EQ(file->bundle.material(), "wood");
  EXPECT_NEAR(file->bundle.mass(), 0.192, 1e-6);
  EXPECT_NEAR(file->bundle.resting(0).height(), 0.02, 1e-5);
}

TEST_F(MeshObject, TheOriginComesUnderTheCentreOfMass) {
  Mesh mesh = box_mesh({0.02, 0.02, 0.02});
  for (Vec3& v : mesh.vertices) v += Vec3(0.3, -0.2, 0.5);
  folder_.write("far.obj", obj_of(mesh));
  const Result<LoadedObject> object = load("far.obj");
  ASSERT_TRUE(object) << object.error().message;
  EXPECT_NEAR(object->bundle.centre_of_mass().x(), 0, 1e-6);
  EXPECT_NEAR(object->bundle.centre_of_mass().y(), 0, 1e-6);
  EXPECT_NEAR(object->bundle.centre_of_mass().z(), 0, 1e-6) << "it may rest on any side";
  EXPECT_EQ(object->bundle.resting_size(), 6);
  EXPECT_NEAR(object->bundle.resting(0).height(), 0.02, 1e-5);
  EXPECT_NEAR(object->bundle.footprint_radius(), 0.02 * std::sqrt(2.0), 5e-4);
  folder_.write("standing.txtpb", "mesh { file: \"far.obj\" } resting_down { z: -1 }");
  const Result<LoadedObject> standing = load("standing.txtpb");
  ASSERT_TRUE(standing) << standing.error().message;
  EXPECT_NEAR(standing->bundle.centre_of_mass().z(), 0.5, 1e-6) << "the file's own height";
  EXPECT_EQ(standing->bundle.resting_size(), 1);
  EXPECT_NEAR(standing->bundle.resting(0).height(), -0.48, 1e-5);
}

TEST_F(MeshObject, AnOpenMeshLoadsWithAWarningThatSaysSo) {
  Mesh mesh = box_mesh({0.02, 0.02, 0.02});
  mesh.triangles.resize(10);
  folder_.write("open.obj", obj_of(mesh));
  const Result<LoadedObject> object = load("open.obj");
  ASSERT_TRUE(object) << object.error().message;
  ASSERT_EQ(object->warnings.size(), 1u);
  EXPECT_NE(object->warnings[0].find("not closed (4 open edges)"), std::string::npos) << object->warnings[0];
  EXPECT_NEAR(object->bundle.mass(), 400 * 6.4e-5, 1e-6);
}

// A bow tie, extruded: one of its two triangles is inside out.
TEST_F(MeshObject, ASurfaceThatCrossesItselfGivesNoBodyThatCannotBe) {
  Mesh mesh;
  for (const double z : {0.0, 0.03})
    for (const auto& [x, y] : {std::pair(-0.05, -0.05), {0.04, 0.04}, {0.04, -0.04}, {-0.05, 0.05}})
      mesh.vertices.emplace_back(x, y, z);
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t j = (i + 1) % 4;
    mesh.triangles.push_back({i, j, j + 4});
    mesh.triangles.push_back({i, j + 4, i + 4});
  }
  orient_outward(mesh);
  ASSERT_EQ(open_edges(mesh), 0u);
  ASSERT_LT(solid_of(mesh).centre.x(), -0.1) << "outside: this is no case";
  folder_.write("tie.obj", obj_of(mesh));
  const Result<LoadedObject> object = load("tie.obj");
  ASSERT_TRUE(object) << object.error().message;
  ASSERT_EQ(object->warnings.size(), 1u);
  EXPECT_NE(object->warnings[0].find("crosses or overlaps itself"), std::string::npos) << object->warnings[0];
  EXPECT_NEAR(object->bundle.mass(), 400 * 0.03 * 0.0081, 1e-4) << "that of the hull";
  const auto& i = object->bundle.inertia();
  for (int k = 0; k < 3; ++k) {
    EXPECT_GT(i[k], 0);
    EXPECT_LT(i[k], i[(k + 1) % 3] + i[(k + 2) % 3]);
  }
  EXPECT_GT(object->bundle.resting_size(), 0);
}

TEST_F(MeshObject, ACupAndItsHandleStayOpenInFewParts) {
  const Result<LoadedObject> cup = load("cup");  // built in, from our own mesh
  ASSERT_TRUE(cup) << cup.error().message;
  const std::vector<proto::ConvexPart> parts(cup->bundle.part().begin(), cup->bundle.part().end());
  EXPECT_LE(parts.size(), 32u);
  // The origin was moved to the centre of mass: find the cup's axis from the visual's far side.
  double least = 1;
  for (int i = 0; i < cup->bundle.visual().xyz_size(); i += 3)
    least = std::min<double>(least, cup->bundle.visual().xyz(i));
  const double x0 = least + 0.039;
  for (const double z : {0.02, 0.04, 0.07}) {
    for (const double x : {-0.022, 0.0, 0.022})
      EXPECT_GT(clearance(parts, {x0 + x, 0, z}), 0.009) << x << " " << z;
  }
  for (const double y : {-0.01, 0.0, 0.01}) EXPECT_GT(clearance(parts, {x0 + 0.0509, y, 0.043}), 0.008) << y;
  for (int i = 0; i < 24; ++i) {
    const double a = 2 * M_PI * i / 24;
    EXPECT_LT(clearance(parts, {x0 + 0.0373 * std::cos(a), 0.0373 * std::sin(a), 0.03}), 0.001) << i;
  }
}

TEST_F(MeshObject, DecompositionsAreCachedAndDamagedEntriesRewritten) {
  const Mesh cup =
      lathe_mesh({{0, 0}, {0.04, 0}, {0.04, 0.08}, {0.036, 0.08}, {0.036, 0.004}, {0, 0.004}}, 20);
  const std::filesystem::path cache = folder_.path() / "cache";
  const auto first = decompose(cup, {}, cache);
  ASSERT_TRUE(first) << first.error().message;
  ASSERT_GT(first->size(), 3u);
  std::vector<std::filesystem::path> entries;
  for (const auto& e : std::filesystem::directory_iterator(cache)) entries.push_back(e.path());
  ASSERT_EQ(entries.size(), 1u);
  const std::string key = entries[0].filename().string().substr(std::string("parts-").size());
  // What is in the cache is what is given out: plant a marked entry.
  std::vector<proto::ConvexPart> planted(first->begin(), first->begin() + 1);
  store_parts(cache, key, planted);
  EXPECT_EQ(decompose(cup, {}, cache)->size(), 1u);
  for (const std::string& damage : {std::string(), std::string("short"), std::string(5000, 'x')}) {
    std::ofstream(entries[0], std::ios::binary | std::ios::trunc) << damage;
    const auto again = decompose(cup, {}, cache);
    ASSERT_TRUE(again);
    ASSERT_EQ(again->size(), first->size());
    for (std::size_t i = 0; i < again->size(); ++i) {
      EXPECT_EQ((*again)[i].SerializeAsString(), (*first)[i].SerializeAsString());
    }
    EXPECT_EQ(cached_parts(cache, key)->size(), first->size()) << "written anew";
  }
  proto::Decomposition other;
  other.set_max_parts(8);
  const auto fewer = decompose(cup, other, cache);
  ASSERT_TRUE(fewer);
  EXPECT_LE(fewer->size(), 8u);
}

TEST_F(MeshObject, ACacheThatCannotBeWrittenIsNoError) {
  folder_.write("file", "in the way");
  const Mesh box = box_mesh({0.02, 0.02, 0.02});
  EXPECT_TRUE(decompose(box, {}, folder_.path() / "file" / "below"));
  EXPECT_TRUE(decompose(box, {}, "/proc/nowhere"));
}

TEST_F(MeshObject, RealScansLoad) {
  const std::filesystem::path data = testing::data_folder();
  if (data.empty()) return;
  for (const char* name : {"mug_ycb/mug_ycb.stl", "tennis_ball_ycb/tennis_ball_ycb.stl",
                           "stapler/stapler.stl", "tumbler_lowpoly/tumbler_lowpoly.stl"}) {
    const std::filesystem::path file = data / "meshes" / name;
    const Result<LoadedObject> object = load(file.string());
    ASSERT_TRUE(object) << object.error().message;
    EXPECT_LE(object->bundle.part_size(), static_cast<int>(proto::Decomposition().max_parts())) << name;
    EXPECT_GT(object->bundle.visual().triangle_size(), 0);
  }
}

// Whatever program wrote them: of every scan and model the triangles, in metres.
TEST_F(MeshObject, RealMeshesAreRead) {
  const std::filesystem::path data = testing::data_folder();
  if (data.empty()) return;
  int read = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(data / "meshes")) {
    if (!is_mesh_file(entry.path())) continue;
    const Result<Mesh> mesh = import_mesh(entry.path(), 1);
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_GT(mesh->triangles.size(), 11u) << entry.path();
    EXPECT_LT(bounds_of(*mesh).extent().maxCoeff(), 0.3) << entry.path();
    ++read;
  }
  EXPECT_GE(read, 21);
}

}  // namespace
}  // namespace evograsp::assets

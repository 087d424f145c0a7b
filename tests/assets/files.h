// Folders, meshes and hostile files for the tests of this room.
#pragma once

#include <stdlib.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "assets/mesh.h"
#include "assets/surface.h"
#include "tests/data_folder.h"

namespace evograsp::assets::testing {

// A folder that goes away with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    char name[] = "/tmp/evograsp-assets-XXXXXX";
    path_ = mkdtemp(name);
  }
  ~TemporaryFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

inline Mesh mesh_from(const proto::TriangleMesh& proto) {
  Mesh mesh;
  for (int i = 0; i + 2 < proto.xyz_size(); i += 3)
    mesh.vertices.emplace_back(proto.xyz(i), proto.xyz(i + 1), proto.xyz(i + 2));
  for (int i = 0; i + 2 < proto.triangle_size(); i += 3) {
    mesh.triangles.push_back({proto.triangle(i), proto.triangle(i + 1), proto.triangle(i + 2)});
  }
  return mesh;
}

inline Mesh box_mesh(const Vec3& half) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1 ? 1 : -1) * half.x(), (i & 2 ? 1 : -1) * half.y(),
                               (i & 4 ? 1 : -1) * half.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

inline Mesh lathe_mesh(const std::vector<ProfilePoint>& profile, int sides) {
  proto::TriangleMesh mesh;
  add_lathe(profile, sides, mesh);
  return mesh_from(mesh);
}

inline std::string obj_of(const Mesh& mesh) {
  std::string out;
  for (const Vec3& v : mesh.vertices) {
    out += "v " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
  }
  for (const auto& t : mesh.triangles) {
    out += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) +
           "\n";
  }
  return out;
}

inline std::string ply_of(const Mesh& mesh) {
  std::string out = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.vertices.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                    std::to_string(mesh.triangles.size()) +
                    "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& v : mesh.vertices) {
    out += std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
  }
  for (const auto& t : mesh.triangles) {
    out += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  }
  return out;
}

inline std::string binary_stl_of(const Mesh& mesh) {
  std::string out(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  out.append(reinterpret_cast<const char*>(&count), 4);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    float values[12] = {};
    for (int k = 0; k < 3; ++k) {
      for (int c = 0; c < 3; ++c) values[3 + 3 * k + c] = static_cast<float>(mesh.corner(t, k)[c]);
    }
    out.append(reinterpret_cast<const char*>(values), sizeof values);
    out.append(2, '\0');
  }
  return out;
}

// Little or big endian, on any machine.
inline void append_number(std::string& out, std::uint32_t bits, bool big) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<char>(bits >> 8 * (big ? 3 - i : i)));
}

inline std::string binary_ply_of(const Mesh& mesh, bool big) {
  std::string out = ply_of(mesh);
  out.resize(out.find("end_header\n") + 11);
  out.replace(out.find("ascii"), 5, big ? "binary_big_endian" : "binary_little_endian");
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k)
      append_number(out, std::bit_cast<std::uint32_t>(static_cast<float>(v[k])), big);
  }
  for (const auto& t : mesh.triangles) {
    out.push_back(3);
    for (const std::uint32_t v : t) append_number(out, v, big);
  }
  return out;
}

// One node with the mesh, its numbers in the document itself; `nodes` replaces the list of nodes.
inline std::string gltf_of(const Mesh& mesh, const std::string& nodes = R"([{"mesh":0}])",
                           const std::string& uri = "") {
  const auto length = [](std::size_t n) { return std::to_string(n); };
  const std::size_t points = 12 * mesh.vertices.size(), indices = 12 * mesh.triangles.size();
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
         R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{)" +
         (uri.empty() ? "" : R"("uri":")" + uri + R"(",)") + R"("byteLength":)" + length(points + indices) +
         R"(}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)" + length(points) +
         R"(},{"buffer":0,"byteOffset":)" + length(points) + R"(,"byteLength":)" + length(indices) +
         R"(}],"accessors":[{"bufferView":0,"componentType":5126,"count":)" + length(mesh.vertices.size()) +
         R"(,"type":"VEC3"},{"bufferView":1,"componentType":5125,"count":)" +
         length(3 * mesh.triangles.size()) + R"(,"type":"SCALAR"}]})";
}

inline std::string gltf_buffer_of(const Mesh& mesh) {
  std::string out;
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k)
      append_number(out, std::bit_cast<std::uint32_t>(static_cast<float>(v[k])), false);
  }
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) append_number(out, v, false);
  }
  return out;
}

inline std::string glb_of(const Mesh& mesh, const std::string& nodes = R"([{"mesh":0}])") {
  std::string json = gltf_of(mesh, nodes);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string buffer = gltf_buffer_of(mesh);
  std::string out = "glTF";
  append_number(out, 2, false);
  append_number(out, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + buffer.size()), false);
  append_number(out, static_cast<std::uint32_t>(json.size()), false);
  out += "JSON" + json;
  append_number(out, static_cast<std::uint32_t>(buffer.size()), false);
  return out + std::string("BIN\0", 4) + buffer;
}

inline std::string dae_of(const Mesh& mesh) {
  std::string points, corners;
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) points += std::to_string(v[k]) + " ";
  }
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) corners += std::to_string(v) + " ";
  }
  const auto count = [](std::size_t n) { return "count=\"" + std::to_string(n) + "\""; };
  return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" )" +
         count(3 * mesh.vertices.size()) + ">" + points + R"(</float_array><technique_common>
<accessor source="#a" stride="3" )" +
         count(mesh.vertices.size()) + R"(><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles )" +
         count(mesh.triangles.size()) + R"(><input semantic="VERTEX" source="#v" offset="0"/><p>)" + corners +
         R"(</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

using evograsp::testing::data_folder;

}  // namespace evograsp::assets::testing

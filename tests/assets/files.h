// Folders, meshes and hostile files for the tests of this room.
#pragma once

#include <stdlib.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "assets/mesh.h"
#include "assets/surface.h"

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

// Data that the repository does not hold: $EVOGRASP_DATA, else shared/data beside the source tree. Empty:
// absent.
inline std::filesystem::path data_folder() {
  const char* given = std::getenv("EVOGRASP_DATA");
  const std::filesystem::path path = given != nullptr
                                         ? std::filesystem::path(given)
                                         : std::filesystem::path(EVOGRASP_SOURCE_DIR) / "../shared/data";
  std::error_code error;
  return std::filesystem::is_directory(path, error) ? path : std::filesystem::path();
}

}  // namespace evograsp::assets::testing

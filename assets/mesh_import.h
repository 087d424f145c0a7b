// Mesh files through assimp (PLY: a reader of our own), behind bounds and in a process of its own.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "assets/mesh.h"
#include "common/result.h"

namespace evograsp::assets {

inline constexpr std::size_t kMaxMeshFile = std::size_t{64} << 20;  // bytes
inline constexpr std::size_t kMaxMeshVertices = 2'000'000;          // as the file counts them
inline constexpr std::size_t kMaxMeshTriangles = 1'000'000;
inline constexpr double kMinMeshSize = 0.002, kMaxMeshSize = 2.0;  // longest side after scaling, m

// .obj .stl .ply .dae .gltf .glb (any case).
bool is_mesh_file(const std::filesystem::path& path);

// The file's triangles in metres (file units x scale), all nodes merged, welded, turned outward. The file's
// own frame is kept, but for DAE and glTF, whose formats say which way is up: their up becomes +z. Nothing
// else is read but *.bin beside a .gltf. Errors name the file and the reason: unreadable, truncated, without
// triangles, not finite, too large, too small or too big after scaling.
Result<Mesh> import_mesh(const std::filesystem::path& path, double scale);
// The same from bytes; name serves messages and its extension the choice of format.
Result<Mesh> import_mesh_bytes(std::string_view bytes, const std::string& name, double scale);

}  // namespace evograsp::assets

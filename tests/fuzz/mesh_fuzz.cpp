// A mesh file of each format, told by the first byte, through the same door as every mesh. Its parser runs in
// a process of its own, so the search is blind there, but for PLY, whose reader is called here as well; what
// comes back is cleaned and measured here. Format 6 is the answer of that process itself, which a hostile
// file may have taken over.
#include <cmath>

#include "assets/hull.h"
#include "assets/mesh.h"
#include "assets/mesh_import.h"
#include "assets/ply.h"
#include "assets/simplify.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace evograsp;

void measure(const assets::Mesh& mesh) {
  for (const Vec3& v : mesh.vertices) fuzz::require(is_finite(v), "vertices are finite");
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) fuzz::require(v < mesh.vertices.size(), "triangles name vertices");
  if (mesh.triangles.size() > 2000) return;
  assets::open_edges(mesh);
  assets::solid_of(mesh);
  assets::convex_hull(mesh.vertices);
  assets::simplified(mesh, 100);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Pieces pieces(data, size);
  constexpr const char* kNames[] = {"m.obj", "m.stl", "m.ply", "m.dae", "m.gltf", "m.glb"};
  const unsigned format = pieces.byte() % 7;
  if (format == 6) {
    if (auto mesh = assets::decode(pieces.rest())) assets::weld(*mesh, 1e-7);
    return 0;
  }
  const auto bytes = pieces.rest();
  if (format == 2) {
    if (const auto mesh = assets::read_ply(bytes)) {
      for (const auto& t : mesh->triangles)
        for (const std::uint32_t v : t) fuzz::require(v < mesh->vertices.size(), "triangles name vertices");
    }
  }
  const auto mesh = assets::import_mesh_bytes(bytes, kNames[format], 1);
  if (mesh)
    measure(*mesh);
  else
    fuzz::require(mesh.error().message.starts_with(kNames[format]), "a refusal names the file");
  return 0;
}

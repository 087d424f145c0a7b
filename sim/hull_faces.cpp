#include "sim/hull_faces.h"

#include <cmath>
#include <cstdio>
#include <memory>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace evograsp::sim {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// A qhull run and its memory.
class Qhull {
 public:
  Qhull() { qh_zero(&state_, nullptr); }
  ~Qhull() {
    qh_freeqhull(&state_, !qh_ALL);
    int large = 0, total = 0;
    qh_memfreeshort(&state_, &large, &total);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  bool run(std::vector<double>& coordinates) {
    const std::unique_ptr<std::FILE, CloseFile> quiet(std::fopen("/dev/null", "w"));
    if (!quiet) return false;
    char command[] = "qhull Qt Pp";
    const int count = static_cast<int>(coordinates.size() / 3);
    return qh_new_qhull(&state_, 3, count, coordinates.data(), False, command, nullptr, quiet.get()) == 0;
  }
  qhT* operator&() { return &state_; }
  facetT* first() const { return state_.facet_list; }

 private:
  qhT state_;
};

}  // namespace

Result<HullFaces> hull_faces(const proto::ConvexPart::Hull& hull) {
  HullFaces out;
  const int values = hull.xyz_size();
  if (values % 3 != 0 || values < 12 || values > 3 * kMaxHullVertices)
    return fail(ErrorCode::kInvalid, "a hull must have 4 to 4096 vertices");
  std::vector<double> coordinates(hull.xyz().begin(), hull.xyz().end());
  for (const double c : coordinates)
    if (!(std::fabs(c) <= 10))
      return fail(ErrorCode::kInvalid, "a hull's vertices must be finite and within 10 m");
  for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3)
    out.vertices.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);

  Qhull run;
  if (!run.run(coordinates)) return fail(ErrorCode::kInvalid, "a hull has no volume");
  qhT* qh = &run;
  facetT* facet = nullptr;
  vertexT *vertex = nullptr, **vertexp = nullptr;
  for (facet = run.first(); facet != nullptr && facet->next != nullptr; facet = facet->next) {
    std::array<std::uint32_t, 3> corner{};
    int n = 0;
    FOREACHvertex_(facet->vertices) {
      if (n < 3)
        corner[static_cast<std::size_t>(n)] = static_cast<std::uint32_t>(qh_pointid(qh, vertex->point));
      ++n;
    }
    if (n != 3) return fail(ErrorCode::kInvalid, "a hull has no volume");
    const Vec3 normal(facet->normal[0], facet->normal[1], facet->normal[2]);
    const Vec3 &a = out.vertices[corner[0]], &b = out.vertices[corner[1]], &c = out.vertices[corner[2]];
    if ((b - a).cross(c - a).dot(normal) < 0) std::swap(corner[1], corner[2]);
    out.triangles.push_back(corner);
    // Triangles of one face carry the very same plane.
    bool known = false;
    for (const HullFaces::Plane& plane : out.planes) known = known || (plane.normal == normal);
    if (!known) out.planes.push_back({normal, -facet->offset});
  }
  if (out.planes.size() < 4) return fail(ErrorCode::kInvalid, "a hull has no volume");
  return out;
}

}  // namespace evograsp::sim

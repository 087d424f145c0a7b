#include "assets/meshgen.h"

#include <cstdio>
#include <vector>

#include "assets/surface.h"
#include "common/det_math.h"

namespace evograsp::assets {
namespace {

std::string obj_text(const proto::TriangleMesh& mesh, const char* what) {
  std::string out = std::string("# ") + what + ", written by evograsp-meshgen; metres\n";
  char line[96];
  for (int i = 0; i + 2 < mesh.xyz_size(); i += 3) {
    std::snprintf(line, sizeof line, "v %.6f %.6f %.6f\n", static_cast<double>(mesh.xyz(i)),
                  static_cast<double>(mesh.xyz(i + 1)), static_cast<double>(mesh.xyz(i + 2)));
    out += line;
  }
  for (int i = 0; i + 2 < mesh.triangle_size(); i += 3) {
    std::snprintf(line, sizeof line, "f %u %u %u\n", mesh.triangle(i) + 1, mesh.triangle(i + 1) + 1,
                  mesh.triangle(i + 2) + 1);
    out += line;
  }
  return out;
}

}  // namespace

std::string bottle_obj() {
  constexpr int kSides = 32, kShoulder = 6;
  const double body = 0.031, neck = 0.012, low = 0.105, high = 0.135, top = 0.165;
  std::vector<ProfilePoint> profile = {
      {0, 0}, {body - 0.003, 0}, {body, 0.003}, {body, low / 2}, {body, low}};
  for (int i = 1; i < kShoulder; ++i) {  // half a cosine from body to neck
    const double t = static_cast<double>(i) / kShoulder;
    profile.push_back({neck + (body - neck) * (1 + det::cos(det::kPi * t)) / 2, low + (high - low) * t});
  }
  for (const ProfilePoint p : {ProfilePoint{neck, high}, {neck, top}, {0, top}}) profile.push_back(p);
  proto::TriangleMesh mesh;
  add_lathe(profile, kSides, mesh);
  return obj_text(mesh, "a bottle");
}

std::string handled_cup_obj() {
  constexpr int kSides = 40, kSteps = 14, kTubeSides = 10;
  const double outer = 0.039, inner = 0.0355, height = 0.086, floor = 0.005, reach = 0.03, rise = 0.025;
  const ProfilePoint profile[] = {{0, 0},          {outer, 0},          {outer, height / 2}, {outer, height},
                                  {inner, height}, {inner, height / 2}, {inner, floor},      {0, floor}};
  proto::TriangleMesh mesh;
  add_lathe(profile, kSides, mesh);
  std::vector<Vec3> path;
  for (int i = 0; i <= kSteps; ++i) {
    const double a = det::kPi * (static_cast<double>(i) / kSteps - 0.5);
    path.emplace_back(outer - 0.0017 + reach * det::cos(a), 0, height / 2 + rise * det::sin(a));
  }
  add_tube(path, 0.0045, kTubeSides, mesh);
  return obj_text(mesh, "a handled cup");
}

}  // namespace evograsp::assets

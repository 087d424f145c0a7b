#include <algorithm>
#include <cmath>
#include <string>

#include "assets/parts.h"
#include "assets/shape.h"
#include "assets/surface.h"
#include "common/det_math.h"

namespace evograsp::assets {
namespace {

constexpr int kWedges = 12;
constexpr int kOuterSteps = 3;  // flats of a wedge's outside
constexpr int kHandleCapsules = 6;
constexpr double kHandleRoot = 0.5;  // the handle's ends lie this share of the wall deep in it

// The handle's centre line: half an ellipse in the xz plane from root to root, bulging towards +x.
std::vector<Vec3> handle_path(const proto::MugShape& m, int steps) {
  const double r = m.handle_thickness() / 2;
  const double root = m.outer_radius() - kHandleRoot * (m.outer_radius() - m.inner_radius());
  const double reach = m.outer_radius() + m.handle_reach() - r - root;
  const double rise = m.handle_height() / 2 - r;
  std::vector<Vec3> path;
  for (int i = 0; i <= steps; ++i) {
    const double a = det::kPi * (static_cast<double>(i) / steps - 0.5);
    path.emplace_back(root + reach * det::cos(a), 0, rise * det::sin(a));
  }
  return path;
}

// One of the wall's wedges; corners alternate about the true circle by as much as the flats cut into it.
proto::ConvexPart wall_wedge(const proto::MugShape& m, int index) {
  const double step = 2 * det::kPi / kWedges, z = m.height() / 2 - kRounding;
  const double outer = m.outer_radius() * 2 / (1 + det::cos(step / kOuterSteps / 2)) - kRounding;
  const double inner = m.inner_radius() * 2 / (1 + det::cos(step / 2)) + kRounding;
  std::vector<Vec3> core;
  for (const double height : {-z, z}) {
    for (int i = 0; i <= kOuterSteps; ++i) {
      const double a = step * (index + static_cast<double>(i) / kOuterSteps);
      core.emplace_back(outer * det::cos(a), outer * det::sin(a), height);
    }
    for (int i = 0; i <= 1; ++i) {
      const double a = step * (index + i);
      core.emplace_back(inner * det::cos(a), inner * det::sin(a), height);
    }
  }
  return hull_part(core, kRounding);
}

std::vector<proto::ConvexPart> mug_parts(const proto::MugShape& m) {
  std::vector<proto::ConvexPart> parts;
  for (int i = 0; i < kWedges; ++i) parts.push_back(wall_wedge(m, i));
  const Pose floor{Mat3::Identity(), {0, 0, (m.floor() - m.height()) / 2}};
  const double into_wall = (m.outer_radius() - m.inner_radius()) / 2;
  parts.push_back(cylinder_part(floor, m.inner_radius() + into_wall, m.floor() / 2));
  const std::vector<Vec3> path = handle_path(m, kHandleCapsules);
  for (int i = 0; i < kHandleCapsules; ++i) {
    parts.push_back(capsule_part(path[i], path[i + 1], m.handle_thickness() / 2));
  }
  return parts;
}

proto::TriangleMesh mug_visual(const proto::MugShape& m) {
  constexpr int kSides = 48, kSteps = 24, kTubeSides = 12;
  const double top = m.height() / 2, ro = m.outer_radius(), ri = m.inner_radius();
  const ProfilePoint profile[] = {
      {0, -top}, {ro, -top}, {ro, top}, {ri, top}, {ri, m.floor() - top}, {0, m.floor() - top}};
  proto::TriangleMesh mesh;
  add_lathe(profile, kSides, mesh);
  add_tube(handle_path(m, kSteps), m.handle_thickness() / 2, kTubeSides, mesh);
  return mesh;
}

// Wall and floor exactly; the handle as short rods wherever its centre line has left the wall.
Solid mug_solid(const proto::MugShape& m) {
  constexpr int kSteps = 256;
  const double cavity = m.height() - m.floor();
  Solid solid =
      solid_cylinder(m.outer_radius(), m.height())
          .minus(solid_cylinder(m.inner_radius(), cavity).moved({Mat3::Identity(), {0, 0, m.floor() / 2}}));
  const std::vector<Vec3> path = handle_path(m, kSteps);
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 middle = (path[i] + path[i + 1]) / 2, along = path[i + 1] - path[i];
    if (middle.x() <= m.outer_radius()) continue;
    const double length = along.norm();
    solid = solid.plus(solid_cylinder(m.handle_thickness() / 2, length)
                           .moved({rotation_between(Vec3::UnitZ(), along / length), middle}));
  }
  return solid;
}

Status check(const proto::MugShape& m) {
  const double wall = m.outer_radius() - m.inner_radius();
  if (wall < 4 * kRounding) {
    return fail(ErrorCode::kInvalid, "mug: outer_radius must exceed inner_radius by at least 2 mm");
  }
  if (m.floor() >= m.height() - 0.005) {
    return fail(ErrorCode::kInvalid, "mug: floor must leave a cavity of at least 5 mm below height");
  }
  if (m.handle_reach() <= m.handle_thickness() || m.handle_height() <= 2 * m.handle_thickness()) {
    return fail(ErrorCode::kInvalid,
                "mug: handle_reach must exceed handle_thickness, and handle_height twice handle_thickness, "
                "to leave a hole");
  }
  if (m.handle_height() > m.height()) {
    return fail(ErrorCode::kInvalid, "mug: handle_height must not exceed height");
  }
  return {};
}

}  // namespace

Result<Shape> mug_shape(const proto::MugShape& shape) {
  if (const Status ok = check(shape); !ok) return tl::unexpected(ok.error());
  return Shape{mug_parts(shape), mug_visual(shape), mug_solid(shape), {}};
}

Result<Shape> plated_mug_shape(const proto::PlatedMugShape& shape) {
  Result<Shape> mug = mug_shape(shape.mug());
  if (!mug) return mug;
  const Pose plate{Mat3::Identity(), {0, 0, -(shape.mug().height() + shape.plate_height()) / 2}};
  const double half = shape.plate_height() / 2, r = shape.plate_radius();
  mug->parts.push_back(cylinder_part(plate, r, half));
  mug->solid = mug->solid.plus(solid_cylinder(r, shape.plate_height()).moved(plate));
  const double z = plate.position.z();
  const ProfilePoint profile[] = {{0, z - half}, {r, z - half}, {r, z + half}, {0, z + half}};
  add_lathe(profile, 48, mug->visual);
  return mug;
}

}  // namespace evograsp::assets

#include "sim/world.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

namespace evograsp::sim {
namespace {

// Stricter than ==, which takes 0 for -0: what was computed from one need not be what the other gives.
bool same_bits(std::span<const double> a, std::span<const double> b) {
  constexpr auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
  return std::ranges::equal(a, b, {}, bits, bits);
}

bool same_bits(const Pose& a, const Pose& b) {
  return same_bits({a.rotation.data(), 9}, {b.rotation.data(), 9}) &&
         same_bits({a.position.data(), 3}, {b.position.data(), 3});
}

bool same(const Placements& a, const Placements& b) {
  if (a.pose.size() != b.pose.size() || a.present != b.present || a.scale != b.scale || a.pose.empty())
    return false;
  for (std::size_t i = 0; i < a.pose.size(); ++i)
    if (!same_bits(a.pose[i], b.pose[i])) return false;
  return true;
}

// The box's top face is the only thing a shape can be near to when its lowest point is above the face.
bool above_table(const Shape& shape, const Pose& pose, const Shape& table, Separation& out) {
  const Vec3 lowest = pose * shape.support(pose.rotation.transpose() * Vec3(0, 0, -1));
  if (!(lowest.z() > 0 && std::fabs(lowest.x()) <= table.half.x() && std::fabs(lowest.y()) <= table.half.y()))
    return false;
  out = {};
  out.distance = lowest.z() - shape.sweep;
  out.normal = Vec3::UnitZ();
  out.on_a = lowest - Vec3(0, 0, shape.sweep);
  out.on_b = {lowest.x(), lowest.y(), 0};
  return true;
}

}  // namespace

Separation distance(const Shape& shape, const Pose& pose, const Obstacle& obstacle,
                    const DistanceOptions& options) {
  Separation out;
  if (obstacle.object == kTableObject && above_table(shape, pose, *obstacle.shape, out)) return out;
  return distance(shape, pose, *obstacle.shape, obstacle.pose, options);
}

Result<World> World::create(const proto::SceneConfig& scene,
                            const std::vector<proto::ObjectBundle>& objects) {
  World world;
  world.table_ = Shape::box({scene.table_half_size(), scene.table_half_size(), kTableThickness / 2}, 0);
  for (const proto::ObjectBundle& bundle : objects) {
    Object object;
    for (const proto::ConvexPart& part : bundle.part()) {
      Result<Shape> shape = Shape::from_proto(part);
      if (!shape) return fail(ErrorCode::kInvalid, "object " + bundle.name() + ": " + shape.error().message);
      object.part.push_back({std::move(*shape), from_proto(part.pose())});
      if (!is_finite(object.part.back().pose))
        return fail(ErrorCode::kInvalid, "object " + bundle.name() + ": a part is not at a finite place");
    }
    object.centre_of_mass = from_proto(bundle.centre_of_mass());
    object.torque_scale = bundle.torque_scale();
    if (object.part.empty())
      return fail(ErrorCode::kInvalid, "object " + bundle.name() + ": has no convex part");
    if (!is_finite(object.centre_of_mass) || !(object.torque_scale > 0 && object.torque_scale < 100))
      return fail(ErrorCode::kInvalid,
                  "object " + bundle.name() + ": no sane centre of mass or torque scale");
    world.objects_.push_back(std::move(object));
  }
  return world;
}

int World::part_count() const {
  int count = 1;
  for (const Object& object : objects_) count += static_cast<int>(object.part.size());
  return count;
}

void World::place_body(std::size_t object, PosedWorld& out) const {
  const Placements& placements = out.placements;
  PosedWorld::Body body;
  body.first = static_cast<int>(out.obstacle.size());
  body.present = object < placements.pose.size() &&
                 (placements.present.size() <= object || placements.present[object] != 0);
  if (body.present) {
    const Pose& X_WB = placements.pose[object];
    const double scale = placements.scale_of(object);
    body.centre_of_mass = X_WB * Vec3(scale * objects_[object].centre_of_mass);
    body.torque_scale = scale * objects_[object].torque_scale;
    for (std::size_t k = 0; k < objects_[object].part.size(); ++k) {
      const Part& part = objects_[object].part[k];
      const Shape* shape = &part.shape;
      if (scale != 1) {
        Shape& sized = out.sized[out.obstacle.size()];
        set_scaled(part.shape, scale, sized);
        shape = &sized;
      }
      const Pose pose = X_WB * Pose{part.pose.rotation, scale * part.pose.position};
      const Aabb box = bounds(*shape, pose);
      out.obstacle.push_back({shape, pose, box, static_cast<int>(object), static_cast<int>(k)});
      body.box.lo = k == 0 ? box.lo : Vec3(body.box.lo.cwiseMin(box.lo));
      body.box.hi = k == 0 ? box.hi : Vec3(body.box.hi.cwiseMax(box.hi));
    }
  }
  body.count = static_cast<int>(out.obstacle.size()) - body.first;
  out.body.push_back(body);
}

void World::place(const Placements& placements, PosedWorld& out) const {
  if (same(placements, out.placements)) return;
  out.placements = placements;
  out.obstacle.clear();
  out.body.clear();
  if (out.sized.empty()) out.sized.resize(static_cast<std::size_t>(part_count()));
  const Pose table{Mat3::Identity(), Vec3(0, 0, -kTableThickness / 2)};
  out.obstacle.push_back({&table_, table, bounds(table_, table), kTableObject, 0});
  for (std::size_t i = 0; i < objects_.size(); ++i) place_body(i, out);
}

}  // namespace evograsp::sim

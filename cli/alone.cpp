#include "cli/alone.h"

#include <algorithm>
#include <cmath>

#include "cli/champion_assets.h"
#include "cli/report.h"
#include "common/pose.h"

namespace evograsp::cli {
namespace {

// How far a part reaches along the unit vector d of the body frame.
double reach(const proto::ConvexPart& part, const Vec3& d) {
  const Pose pose = from_proto(part.pose());
  const Vec3 local = pose.rotation.transpose() * d;
  const double across = std::hypot(local.x(), local.y());
  double core = 0;
  switch (part.shape_case()) {
    case proto::ConvexPart::kBox:
      core = std::abs(local.x()) * part.box().hx() + std::abs(local.y()) * part.box().hy() +
             std::abs(local.z()) * part.box().hz();
      break;
    case proto::ConvexPart::kBall:
      core = part.ball().radius();
      break;
    case proto::ConvexPart::kCylinder:
      core = part.cylinder().radius() * across + part.cylinder().half_length() * std::abs(local.z());
      break;
    case proto::ConvexPart::kCapsule:
      core = part.capsule().radius() + part.capsule().half_length() * std::abs(local.z());
      break;
    case proto::ConvexPart::kHull:
      core = -HUGE_VAL;
      for (int i = 0; i + 2 < part.hull().xyz_size(); i += 3) {
        core = std::max(core, local.x() * part.hull().xyz(i) + local.y() * part.hull().xyz(i + 1) +
                                  local.z() * part.hull().xyz(i + 2));
      }
      core += part.rounding();  // the other shapes' sizes hold it already
      break;
    case proto::ConvexPart::SHAPE_NOT_SET:
      break;
  }
  return d.dot(pose.position) + core;
}

double width_along(const proto::ObjectBundle& object, const Vec3& d) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const proto::ConvexPart& part : object.part()) {
    high = std::max(high, reach(part, d));
    low = std::min(low, -reach(part, -d));
  }
  return high - low;
}

}  // namespace

Result<std::shared_ptr<const sim::Simulator>> alone(const proto::Champion& champion,
                                                    const std::string& object, const assets::Bundles& at_hand,
                                                    double scale, double mass) {
  proto::Config config = champion.experiment();
  proto::SceneConfig& scene = *config.mutable_scene();
  scene.clear_object();
  scene.add_object(object);
  scene.set_objects_in_scene(0);
  if (scale > 0) scene.set_mesh_scale(scale);
  if (mass > 0) scene.set_mesh_mass(mass);
  auto experiment = resolve_trained(config, at_hand, "--objects");
  if (!experiment) return tl::unexpected(experiment.error());
  for (const std::string& warning : experiment->warnings) warn(warning);
  return sim::Simulator::create(experiment->experiment, experiment->objects, experiment->hand);
}

double smallest_width(const proto::ObjectBundle& object) {
  if (object.part_size() == 0) return 0;
  double smallest = std::min({width_along(object, Vec3::UnitX()), width_along(object, Vec3::UnitY()),
                              width_along(object, Vec3::UnitZ())});
  // Evenly over a hemisphere: equal steps of height, the golden angle between neighbours.
  constexpr int kDirections = 240;
  constexpr double kGoldenAngle = 2.399963229728653;
  for (int i = 0; i < kDirections; ++i) {
    const double z = (i + 0.5) / kDirections, r = std::sqrt(1 - z * z);
    const Vec3 d(r * std::cos(i * kGoldenAngle), r * std::sin(i * kGoldenAngle), z);
    smallest = std::min(smallest, width_along(object, d));
  }
  return smallest;
}

}  // namespace evograsp::cli

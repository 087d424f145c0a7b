#include "sim/scene.h"

#include <cmath>

#include "common/det_math.h"
#include "common/scene_subset.h"

namespace evograsp::sim {
namespace {

// A layout that has refused this many positions for one object is begun again: objects placed first can leave
// no room.
constexpr int kTriesBeforeRestart = 64;
constexpr std::uint64_t kSizeStream = 2000000;  // of the domain randomisation

std::string label(const proto::ObjectBundle& object, std::size_t index) {
  return "object " + std::to_string(index + 1) + " (" + object.name() + ")";
}

}  // namespace

Result<Scene> Scene::create(const proto::SceneConfig& config, const Camera& camera,
                            const std::vector<proto::ObjectBundle>& objects) {
  Scene scene;
  scene.config_ = config;
  scene.camera_ = camera;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const proto::ObjectBundle& object = objects[i];
    Item item;
    item.name = object.name();
    item.footprint = object.footprint_radius();
    if (object.resting_size() < 1 || object.resting_size() > 256)
      return fail(ErrorCode::kInvalid, label(object, i) + " needs 1 to 256 resting poses");
    if (!(item.footprint > 0 && item.footprint <= config.table_half_size()))
      return fail(ErrorCode::kInvalid, label(object, i) +
                                           " does not fit on the table: its footprint radius is " +
                                           std::to_string(item.footprint) + " m, the table's half size " +
                                           std::to_string(config.table_half_size()) + " m");
    for (const proto::RestingPose& resting : object.resting()) {
      item.rotation.push_back(from_proto(resting.orientation()));
      item.height.push_back(resting.height());
      if (!is_finite(Pose{item.rotation.back(), Vec3::Zero()}))
        return fail(ErrorCode::kInvalid, label(object, i) + " has a resting orientation that is no rotation");
      if (!std::isfinite(resting.height()) || std::fabs(resting.height()) > 10)
        return fail(ErrorCode::kInvalid, label(object, i) + " has a resting height that is no length");
    }
    std::vector<Solid> parts;
    for (const proto::ConvexPart& part : object.part()) {
      Result<Solid> solid = Solid::create(part);
      if (!solid) return fail(solid.error().code, label(object, i) + ": " + solid.error().message);
      parts.push_back(std::move(*solid));
    }
    if (parts.empty()) return fail(ErrorCode::kInvalid, label(object, i) + " has no parts");
    item.bounds = ImageBounds(std::move(parts));
    scene.items_.push_back(std::move(item));
  }
  return scene;
}

bool Scene::fits(std::size_t index, const Placements& placements, const Camera& camera) const {
  const Vec3& at = placements.pose[index].position;
  for (std::size_t j = 0; j < index; ++j) {
    if (!placements.present[j]) continue;
    const double dx = at.x() - placements.pose[j].position.x();
    const double dy = at.y() - placements.pose[j].position.y();
    const double apart = placements.scale[index] * items_[index].footprint +
                         placements.scale[j] * items_[j].footprint + config_.clearance();
    if (dx * dx + dy * dy < apart * apart) return false;
  }
  const std::optional<ImageBox> box =
      items_[index].bounds.project(camera, placements.pose[index], placements.scale[index]);
  return box && box->inside(camera);
}

Result<Placements> Scene::shuffle(std::uint64_t seed) const {
  Placements out;
  out.seed = seed;
  out.pose.assign(items_.size(), Pose());
  out.resting.assign(items_.size(), 0);
  out.present = scene_subset(seed, static_cast<std::uint32_t>(items_.size()), config_.objects_in_scene());
  out.scale.assign(items_.size(), 1);
  for (std::size_t k = 0; config_.size_jitter() > 0 && k < items_.size(); ++k) {
    Random size(seed, Purpose::kDomain, 0, kSizeStream + k);
    out.scale[k] = size.uniform(1 - config_.size_jitter(), 1 + config_.size_jitter());
  }
  const Camera camera = camera_.of_placement(seed);
  Random random(seed, Purpose::kPlacement);
  std::uint64_t tries = 0;
  std::size_t i = 0;
  int refused = 0;
  while (i < items_.size()) {
    if (!out.present[i]) {
      ++i;
      continue;
    }
    if (tries++ >= config_.placement_tries())
      return fail(
          ErrorCode::kInvalid,
          "scene: no room for " + items_[i].name + " (object " + std::to_string(i + 1) + ") after " +
              std::to_string(config_.placement_tries()) +
              " tries: widen placement_half_x and placement_half_y, lower objects_in_scene or clearance, or "
              "move the camera so that it sees the whole area");
    const Item& item = items_[i];
    const double x = random.uniform(-config_.placement_half_x(), config_.placement_half_x());
    const double y = random.uniform(-config_.placement_half_y(), config_.placement_half_y());
    const double yaw = random.uniform(-det::kPi, det::kPi);
    const std::uint32_t face = random.below(static_cast<std::uint32_t>(item.rotation.size()));
    out.resting[i] = static_cast<std::uint8_t>(face);
    out.pose[i].rotation = rotation_about(Vec3(0, 0, 1), yaw) * item.rotation[face];
    out.pose[i].position = Vec3(x, y, out.scale[i] * item.height[face]);
    if (fits(i, out, camera)) {
      ++i;
      refused = 0;
    } else if (++refused >= kTriesBeforeRestart) {
      i = 0;
      refused = 0;
    }
  }
  return out;
}

}  // namespace evograsp::sim

#include "assets/hand_geometry.h"

#include <cmath>

#include "assets/parts.h"
#include "assets/urdf.h"

namespace evograsp::assets {
namespace {

struct Item {
  urdf::GeometrySharedPtr geometry;
  Pose pose;
};

std::vector<Item> items_of(const urdf::Link& link, const Pose& pose, bool visual) {
  std::vector<Item> items;
  const auto add = [&](const auto& element) {
    if (element && element->geometry) items.push_back({element->geometry, pose * snapped(element->origin)});
  };
  if (visual) {
    for (const auto& v : link.visual_array) add(v);
  } else {
    for (const auto& c : link.collision_array) add(c);
  }
  return items;
}

bool good_size(double v) {
  return std::isfinite(v) && v >= 1e-5 && v <= 2;
}

// The balls at both ends of a cylinder, if they are there: indices into items.
std::optional<std::pair<std::size_t, std::size_t>> end_balls(const std::vector<Item>& items,
                                                             const std::vector<bool>& used, const Pose& pose,
                                                             const urdf::Cylinder& rod) {
  std::optional<std::size_t> found[2];
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (used[i] || items[i].geometry->type != urdf::Geometry::SPHERE) continue;
    if (std::fabs(static_cast<const urdf::Sphere&>(*items[i].geometry).radius - rod.radius) > 1e-6) continue;
    const Vec3 at = pose.inverse() * items[i].pose.position;
    for (int end = 0; end < 2; ++end) {
      const Vec3 tip(0, 0, (end == 0 ? -0.5 : 0.5) * rod.length);
      if (!found[end] && (at - tip).norm() < 1e-5) found[end] = i;
    }
  }
  if (!found[0] || !found[1] || *found[0] == *found[1]) return std::nullopt;
  return std::pair{*found[0], *found[1]};
}

class LinkParts {
 public:
  LinkParts(const urdf::Link& link, const GeometrySource& source, std::vector<std::string>& warnings)
      : link_(link), source_(source), warnings_(warnings) {}

  Result<std::vector<proto::ConvexPart>> make(const std::vector<Item>& items) {
    if (items.size() > 3 * kMaxPartsPerLink)
      return fail(ErrorCode::kInvalid, where() + "too many collision shapes");
    std::vector<bool> used(items.size(), false);
    for (std::size_t i = 0; i < items.size(); ++i) {  // rods first: they may take balls with them
      if (items[i].geometry->type != urdf::Geometry::CYLINDER) continue;
      used[i] = true;
      if (const Status ok = add_rod(items, used, items[i]); !ok) return tl::unexpected(ok.error());
    }
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (used[i]) continue;
      if (const Status ok = add(items[i]); !ok) return tl::unexpected(ok.error());
    }
    if (parts_.size() > kMaxPartsPerLink)
      return fail(ErrorCode::kInvalid, where() + "too many collision shapes");
    return std::move(parts_);
  }

 private:
  std::string where() const { return "link '" + link_.name + "': "; }

  Status add_rod(const std::vector<Item>& items, std::vector<bool>& used, const Item& item) {
    const auto& rod = static_cast<const urdf::Cylinder&>(*item.geometry);
    if (!good_size(rod.radius) || !good_size(rod.length)) {
      return fail(ErrorCode::kInvalid, where() + "cylinder sizes must be within 0.01 mm and 2 m");
    }
    if (const auto balls = end_balls(items, used, item.pose, rod)) {
      used[balls->first] = used[balls->second] = true;
      const Vec3 tip(0, 0, rod.length / 2);
      parts_.push_back(capsule_part(item.pose * -tip, item.pose * tip, rod.radius));
    } else {
      parts_.push_back(cylinder_part(item.pose, rod.radius, rod.length / 2, source_.rounding));
    }
    return {};
  }

  Status add(const Item& item) {
    switch (item.geometry->type) {
      case urdf::Geometry::BOX: {
        const urdf::Vector3& dim = static_cast<const urdf::Box&>(*item.geometry).dim;
        if (!good_size(dim.x) || !good_size(dim.y) || !good_size(dim.z)) {
          return fail(ErrorCode::kInvalid, where() + "box sizes must be within 0.01 mm and 2 m");
        }
        parts_.push_back(box_part(item.pose, Vec3(dim.x, dim.y, dim.z) / 2, source_.rounding));
        return {};
      }
      case urdf::Geometry::SPHERE: {
        const double radius = static_cast<const urdf::Sphere&>(*item.geometry).radius;
        if (!good_size(radius))
          return fail(ErrorCode::kInvalid, where() + "sphere radius must be within 0.01 mm and 2 m");
        parts_.push_back(ball_part(item.pose.position, radius));
        return {};
      }
      default:
        return {};
    }
  }

  const urdf::Link& link_;
  const GeometrySource& source_;
  std::vector<std::string>& warnings_;
  std::vector<proto::ConvexPart> parts_;
};

}  // namespace

Result<std::vector<proto::ConvexPart>> link_parts(const urdf::Link& link, const Pose& pose,
                                                  const GeometrySource& source,
                                                  std::vector<std::string>& warnings) {
  for (const bool visual : {false, true}) {
    const std::vector<Item> items = items_of(link, pose, visual);
    if (items.empty()) continue;
    Result<std::vector<proto::ConvexPart>> parts = LinkParts(link, source, warnings).make(items);
    if (!parts || !parts->empty()) return parts;
  }
  return std::vector<proto::ConvexPart>{};
}

}  // namespace evograsp::assets

#include "assets/hand_geometry.h"

#include <cmath>

#include "assets/hull.h"
#include "assets/mesh_import.h"
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

namespace fs = std::filesystem;
constexpr std::size_t kMeshVertices = 32;  // of a link's hull

// The file that a URDF's mesh name means. package://NAME/PATH is looked up in the packages given, else in
// folders called NAME from the URDF's own upwards; anything that climbs out of its package, or another
// scheme, is refused.
Result<fs::path> mesh_path(const std::string& name, const GeometrySource& source) {
  constexpr std::string_view kPackage = "package://", kFile = "file://";
  constexpr int kLevels = 5;
  if (source.urdf_folder.empty())
    return fail(ErrorCode::kInvalid, "mesh '" + name + "': built-in hands have none");
  std::string_view rest = name;
  if (rest.starts_with(kFile)) rest.remove_prefix(kFile.size());
  if (!rest.starts_with(kPackage)) {
    if (rest.find("://") != std::string_view::npos)
      return fail(ErrorCode::kUnsupported, "mesh '" + name + "': only package:// and files");
    return source.urdf_folder / fs::path(rest);
  }
  rest.remove_prefix(kPackage.size());
  const fs::path inside = fs::path(rest.substr(std::min(rest.size(), rest.find('/') + 1))).lexically_normal();
  const std::string package(rest.substr(0, rest.find('/')));
  if (package.empty() || package.starts_with(".") || inside.is_absolute() || *inside.begin() == "..") {
    return fail(ErrorCode::kInvalid, "mesh '" + name + "': leads out of its package");
  }
  if (const auto given = source.packages.find(package); given != source.packages.end())
    return given->second / inside;
  std::error_code error;
  fs::path folder = source.urdf_folder;
  for (int level = 0; level < kLevels; ++level, folder = folder.parent_path()) {
    if (fs::exists(folder / package / inside, error)) return folder / package / inside;
  }
  return fail(ErrorCode::kNotFound,
              "mesh '" + name + "': no such file in a folder '" + package +
                  "' at or above the URDF (name the folder with `package` in a hand file)");
}

Result<Mesh> import_hand_mesh(const urdf::Mesh& mesh, const GeometrySource& source) {
  for (const double s : {mesh.scale.x, mesh.scale.y, mesh.scale.z}) {
    if (!std::isfinite(s) || s == 0 || std::fabs(s) > 1000)
      return fail(ErrorCode::kInvalid, "mesh scale is not usable");
  }
  const Result<fs::path> path = mesh_path(mesh.filename, source);
  if (!path) return tl::unexpected(path.error());
  return import_mesh(*path, std::fabs(mesh.scale.x));
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
      case urdf::Geometry::MESH:
        return add_mesh(item);
      default:
        return {};
    }
  }

  // A mesh as its convex hull. A file that is not there or cannot be used is a warning: the link may have
  // others.
  Status add_mesh(const Item& item) {
    const auto& mesh = static_cast<const urdf::Mesh&>(*item.geometry);
    const Result<Mesh> imported = import_hand_mesh(mesh, source_);
    if (!imported) {
      warnings_.push_back(where() + imported.error().message);
      return {};
    }
    const Vec3 ratio = Vec3(mesh.scale.x, mesh.scale.y, mesh.scale.z) / std::fabs(mesh.scale.x);
    std::vector<Vec3> points;
    for (const Vec3& v : imported->vertices) points.push_back(item.pose * v.cwiseProduct(ratio));
    parts_.push_back(part_from_points(points, kMeshVertices, source_.rounding));
    return {};
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

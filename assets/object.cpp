#include <algorithm>
#include <cmath>

#include "assets/assets.h"
#include "assets/bundle.h"
#include "assets/mesh_import.h"
#include "assets/mesh_shape.h"
#include "assets/parts.h"
#include "assets/resting.h"
#include "assets/shape.h"
#include "assets/text.h"
#include "common/digest.h"
#include "proto/object.pb.h"

namespace evograsp::assets {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxObjectFile = 1 << 20;  // bytes

struct Alias {
  std::string_view name, stands_for;
};
constexpr Alias kAliases[] = {{"cube", "cube_6cm"}, {"sphere", "sphere_4cm"}};

std::string_view canonical(std::string_view name) {
  for (const Alias& alias : kAliases) {
    if (alias.name == name) return alias.stands_for;
  }
  return name;
}

// The object's frame turned so that `down` points to the table, and the height at which its lowest point is
// on z = 0.
proto::RestingPose resting_pose(const std::vector<proto::ConvexPart>& parts, const Vec3& down) {
  double lowest = -HUGE_VAL;
  for (const auto& part : parts) lowest = std::max(lowest, support(part, down));
  proto::RestingPose pose;
  *pose.mutable_orientation() = to_proto(rotation_between(down, -Vec3::UnitZ()));
  pose.set_height(lowest);
  return pose;
}

// What the file says; else a mesh rests on its stable faces and the other shapes as they are modelled.
Result<std::vector<Vec3>> resting_directions(const proto::ObjectFile& file, const Shape& shape) {
  std::vector<Vec3> directions;
  for (const proto::Vec3& v : file.resting_down()) {
    const std::optional<Vec3> down = direction_of(from_proto(v));
    if (!down) return fail(ErrorCode::kInvalid, "resting_down: a direction must be finite and not zero");
    directions.push_back(*down);
  }
  if (directions.empty() && file.has_mesh()) {
    std::vector<Vec3> points;
    for (int i = 0; i + 2 < shape.visual.xyz_size(); i += 3)
      points.emplace_back(shape.visual.xyz(i), shape.visual.xyz(i + 1), shape.visual.xyz(i + 2));
    for (const RestingFace& face : resting_faces(points, shape.solid.centre)) directions.push_back(face.down);
  }
  if (directions.empty()) directions.push_back(-Vec3::UnitZ());
  return directions;
}

void set_mass(const proto::ObjectFile& file, const Solid& solid, proto::ObjectBundle& bundle) {
  const double mass = file.has_mass() ? file.mass() : file.density() * solid.volume;
  bundle.set_mass(mass);
  *bundle.mutable_centre_of_mass() = to_proto(solid.centre);
  const Mat3 inertia = solid.inertia * (mass / solid.volume);
  for (const double v :
       {inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(0, 2), inertia(1, 2)}) {
    bundle.add_inertia(v);
  }
}

Result<LoadedObject> finish(const proto::ObjectFile& file, Shape shape, const std::string& source) {
  if (!(shape.solid.volume > 0)) return fail(ErrorCode::kInvalid, source + ": the shape encloses no volume");
  const Result<std::vector<Vec3>> directions = resting_directions(file, shape);
  if (!directions) return fail(directions.error().code, source + ": " + directions.error().message);
  LoadedObject out;
  out.warnings = std::move(shape.warnings);
  proto::ObjectBundle& bundle = out.bundle;
  bundle.set_name(file.name());
  bundle.set_material(file.material());
  bundle.set_source(source);
  set_mass(file, shape.solid, bundle);
  double reach = 0, footprint = 0;
  for (const auto& part : shape.parts) reach = std::max(reach, farthest(part, shape.solid.centre));
  for (const Vec3& down : *directions) {
    *bundle.add_resting() = resting_pose(shape.parts, down);
    for (const auto& part : shape.parts) footprint = std::max(footprint, axis_reach(part, down));
  }
  bundle.set_torque_scale(reach);
  bundle.set_footprint_radius(footprint);
  for (auto& part : shape.parts) *bundle.add_part() = std::move(part);
  if (shape.visual.triangle_size() > 0) *bundle.mutable_visual() = std::move(shape.visual);
  if (const Status ok = check_size(bundle); !ok)
    return fail(ok.error().code, source + ": " + ok.error().message);
  out.id = bundle_id(bundle);
  return out;
}

// Where an object file came from and what it may lean on.
struct Origin {
  std::string file_name;  // for messages
  fs::path folder;        // of relative mesh files
  bool embedded = false;  // mesh files are embedded beside it
  bool bare = false;      // no object file: this is the mesh
  fs::path cache;
};

Result<Shape> shape_of_mesh(const proto::MeshShape& shape, Centring centring, const Origin& origin) {
  const auto imported = [&]() -> Result<Mesh> {
    if (!origin.embedded) return import_mesh(origin.folder / shape.file(), shape.scale());
    const auto bytes = embedded_file("objects/" + shape.file());
    if (!bytes) return fail(ErrorCode::kNotFound, "its mesh '" + shape.file() + "' is not built in");
    return import_mesh_bytes(*bytes, shape.file(), shape.scale());
  };
  const Result<Mesh> mesh = imported();
  if (!mesh) return tl::unexpected(mesh.error());
  return mesh_shape(*mesh, shape.file(), shape.decomposition(), origin.cache, centring);
}

Result<Shape> build_shape(const proto::ObjectFile& file, const Origin& origin) {
  switch (file.shape_case()) {
    case proto::ObjectFile::kCylinder:
      return cylinder_shape(file.cylinder());
    case proto::ObjectFile::kCuboid:
      return cuboid_shape(file.cuboid());
    case proto::ObjectFile::kSphere:
      return sphere_shape(file.sphere());
    case proto::ObjectFile::kMug:
      return mug_shape(file.mug());
    case proto::ObjectFile::kPlatedMug:
      return plated_mug_shape(file.plated_mug());
    case proto::ObjectFile::kMesh:
      return shape_of_mesh(file.mesh(), file.resting_down().empty() ? Centring::kWholly : Centring::kSideways,
                           origin);
    case proto::ObjectFile::SHAPE_NOT_SET:
      break;
  }
  return fail(ErrorCode::kInvalid,
              "no shape; one of cylinder, cuboid, sphere, mug, plated_mug, mesh is needed");
}

Result<LoadedObject> build_object(const proto::ObjectFile& file, const Origin& origin) {
  const std::string source = fs::path(origin.file_name).filename().string();
  Result<Shape> shape = build_shape(file, origin);
  if (!shape) {  // a mesh's own errors name its file
    return fail(shape.error().code, (origin.bare ? "" : origin.file_name + ": ") + shape.error().message);
  }
  return finish(file, std::move(*shape), source);
}

Result<LoadedObject> object_from_text(std::string_view text, const Origin& origin) {
  proto::ObjectFile file;
  if (const Status ok = parse_message(text, origin.file_name, file); !ok) return tl::unexpected(ok.error());
  if (!file.has_name()) file.set_name(fs::path(origin.file_name).stem().string());
  return build_object(file, origin);
}

}  // namespace

std::vector<std::string> builtin_objects() {
  return builtin_names("objects/");
}

std::vector<std::string> object_names() {
  std::vector<std::string> names = builtin_objects();
  for (const Alias& alias : kAliases) names.emplace_back(alias.name);
  std::sort(names.begin(), names.end());
  return names;
}

Result<LoadedObject> load_object(const std::string& name_or_path, const ObjectOptions& options) {
  Origin origin;
  origin.cache = options.cache.empty() ? default_cache_folder() : options.cache;
  origin.file_name = "objects/" + std::string(canonical(name_or_path)) + ".txtpb";
  if (const auto text = embedded_file(origin.file_name)) {
    origin.embedded = true;
    return object_from_text(*text, origin);
  }
  const fs::path path = find_file(name_or_path, options.base);
  if (path.empty())
    return fail(ErrorCode::kNotFound, unknown_name("object", name_or_path, builtin_objects()));
  origin.file_name = path.string();
  origin.folder = path.parent_path();
  if (is_mesh_file(path)) {
    origin.bare = true;
    proto::ObjectFile file;
    file.set_name(path.stem().string());
    file.mutable_mesh()->set_file(path.filename().string());
    file.mutable_mesh()->set_scale(options.mesh_scale);
    if (options.mesh_mass > 0) file.set_mass(options.mesh_mass);
    return build_object(file, origin);
  }
  const Result<std::string> text = read_file(path, kMaxObjectFile);
  if (!text) return tl::unexpected(text.error());
  return object_from_text(*text, origin);
}

}  // namespace evograsp::assets

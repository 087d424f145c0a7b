#include "sim/triangle_mesh.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace evograsp::sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}
double dot(const Vec3& a, const Vec3& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

// One device a process. The instruction set is fixed, so that the tree is the same everywhere.
RTCDevice device() {
  static const RTCDevice the_device = rtcNewDevice("threads=1,set_affinity=0,isa=sse4.2");
  return the_device;
}

}  // namespace

struct TriangleMesh::Culling {
  RTCScene scene = nullptr;
  ~Culling() {
    if (scene) rtcReleaseScene(scene);
  }
};

// What one ray carries through Embree's tree. The context comes first: Embree hands it back.
struct TriangleMesh::Query {
  RTCIntersectContext context;
  const Ray* ray;
  double t_min;
  double t;
  int triangle;
};

bool TriangleMesh::meets(std::size_t triangle, const Ray& ray, double t_min, double* t) const {
  const Face& face = faces_[triangle];
  const Vec3 a = face.corner[0] - ray.origin, b = face.corner[1] - ray.origin,
             c = face.corner[2] - ray.origin;
  // Signed volumes of the ray with each edge. Neighbours compute their common edge from the same two points,
  // so their values are exact opposites and no ray slips between them.
  const double u = dot(ray.direction, cross(b, c));
  const double v = dot(ray.direction, cross(c, a));
  const double w = dot(ray.direction, cross(a, b));
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
  const double volume = u + v + w;
  if (volume == 0) return false;
  // Depth as the mean of the corners' depths weighted by these volumes: however thin the triangle, within
  // their range.
  const Vec3& d = ray.direction;
  const double at = (u * dot(a, d) + v * dot(b, d) + w * dot(c, d)) / (volume * dot(d, d));
  if (!(at > t_min && at <= *t)) return false;
  *t = at;
  return true;
}

int TriangleMesh::enter_by_scan(const Ray& ray, double t_min, double* t) const {
  int best = -1;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    double at = *t;
    if (meets(i, ray, t_min, &at) && at < *t) *t = at, best = static_cast<int>(i);
  }
  return best;
}

int TriangleMesh::enter(const Ray& ray, double t_min, double* t) const {
  Query query;
  rtcInitIntersectContext(&query.context);
  query.ray = &ray;
  query.t_min = t_min;
  query.t = *t;
  query.triangle = -1;
  RTCRayHit hit;
  hit.ray.org_x = static_cast<float>(ray.origin.x());
  hit.ray.org_y = static_cast<float>(ray.origin.y());
  hit.ray.org_z = static_cast<float>(ray.origin.z());
  hit.ray.dir_x = static_cast<float>(ray.direction.x());
  hit.ray.dir_y = static_cast<float>(ray.direction.y());
  hit.ray.dir_z = static_cast<float>(ray.direction.z());
  hit.ray.tnear = static_cast<float>(std::max(0.0, t_min - kCullingMargin));
  hit.ray.tfar = *t < 1e30 ? static_cast<float>(*t + kCullingMargin) : std::numeric_limits<float>::infinity();
  hit.ray.time = 0, hit.ray.mask = ~0u, hit.ray.id = 0, hit.ray.flags = 0;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID, hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(culling_->scene, &query.context, &hit);
  if (query.triangle >= 0) *t = query.t;
  return query.triangle;
}

Vec3 TriangleMesh::normal(int triangle) const {
  const Vec3& n = faces_[static_cast<std::size_t>(triangle)].normal;
  const double size = std::sqrt(dot(n, n));
  return size > 0 ? Vec3(n / size) : Vec3(Vec3::UnitZ());
}

TriangleMesh::~TriangleMesh() = default;

Result<std::shared_ptr<const TriangleMesh>> TriangleMesh::create(const proto::TriangleMesh& proto) {
  std::shared_ptr<TriangleMesh> mesh(new TriangleMesh);
  if (proto.xyz_size() % 3 != 0 || proto.triangle_size() % 3 != 0 || proto.triangle_size() == 0)
    return fail(ErrorCode::kInvalid, "a mesh must have whole vertices and at least one whole triangle");
  std::vector<Vec3> vertex;
  for (int i = 0; i + 2 < proto.xyz_size(); i += 3) {
    vertex.emplace_back(proto.xyz(i), proto.xyz(i + 1), proto.xyz(i + 2));
    for (int k = 0; k < 3; ++k)
      if (!(std::fabs(vertex.back()[k]) <= 10))
        return fail(ErrorCode::kInvalid, "a mesh's vertices must be finite and within 10 m of its origin");
  }
  Vec3 low = Vec3::Constant(kInfinity), high = -low;
  for (int i = 0; i + 2 < proto.triangle_size(); i += 3) {
    Face face;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t index = proto.triangle(i + k);
      if (index >= vertex.size())
        return fail(ErrorCode::kInvalid, "a mesh's triangle names a vertex it lacks");
      face.corner[k] = vertex[index];
      low = low.cwiseMin(vertex[index]), high = high.cwiseMax(vertex[index]);
    }
    face.normal = cross(face.corner[1] - face.corner[0], face.corner[2] - face.corner[0]);
    mesh->faces_.push_back(face);
  }
  mesh->ball_.centre = 0.5 * (low + high);
  for (const Face& face : mesh->faces_)
    for (const Vec3& corner : face.corner) {
      const Vec3 d = corner - mesh->ball_.centre;
      mesh->ball_.radius = std::max(mesh->ball_.radius, std::sqrt(dot(d, d)) + 1e-9);
    }
  if (Status s = mesh->build_culling(); !s) return tl::unexpected(s.error());
  return mesh;
}

Status TriangleMesh::build_culling() {
  if (!device()) return fail(ErrorCode::kInternal, "Embree gives no device on this processor");
  culling_ = std::make_unique<Culling>();
  culling_->scene = rtcNewScene(device());
  rtcSetSceneFlags(culling_->scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(faces_.size()));
  rtcSetGeometryUserData(geometry, this);
  rtcSetGeometryBoundsFunction(
      geometry,
      [](const RTCBoundsFunctionArguments* args) {
        const auto& face = static_cast<const TriangleMesh*>(args->geometryUserPtr)->faces_[args->primID];
        const Vec3 low = face.corner[0].cwiseMin(face.corner[1]).cwiseMin(face.corner[2]);
        const Vec3 high = face.corner[0].cwiseMax(face.corner[1]).cwiseMax(face.corner[2]);
        const auto below = [](double x) { return static_cast<float>(x - kCullingMargin); };
        const auto above = [](double x) { return static_cast<float>(x + kCullingMargin); };
        *args->bounds_o = {below(low.x()),  below(low.y()),  below(low.z()),  0,
                           above(high.x()), above(high.y()), above(high.z()), 0};
      },
      nullptr);
  rtcSetGeometryIntersectFunction(geometry, [](const RTCIntersectFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* query = reinterpret_cast<Query*>(args->context);
    const auto* mesh = static_cast<const TriangleMesh*>(args->geometryUserPtr);
    double at = query->t;
    if (!mesh->meets(args->primID, *query->ray, query->t_min, &at)) return;
    const int triangle = static_cast<int>(args->primID);
    if (at == query->t && (query->triangle < 0 || triangle > query->triangle)) return;
    query->t = at;
    query->triangle = triangle;
    auto* hit = reinterpret_cast<RTCRayHit*>(args->rayhit);
    hit->ray.tfar = static_cast<float>(at + kCullingMargin);
    hit->hit.geomID = args->geomID;
    hit->hit.primID = args->primID;
  });
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(culling_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(culling_->scene);
  if (const RTCError error = rtcGetDeviceError(device()); error != RTC_ERROR_NONE)
    return fail(ErrorCode::kInternal, "Embree cannot build a tree: error " + std::to_string(error));
  return {};
}

}  // namespace evograsp::sim

#include "sim/ray_caster.h"

#include <cmath>

namespace evograsp::sim {
namespace {

double dot(const Vec3& a, const Vec3& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

// A ball around the parts' balls: centred on the box that holds them.
BoundingBall around(const std::vector<Solid>& parts) {
  if (parts.empty()) return {};
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  for (const Solid& part : parts) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], part.support(-Vec3::Unit(k))[k]);
      high[k] = std::max(high[k], part.support(Vec3::Unit(k))[k]);
    }
  }
  BoundingBall ball;
  ball.centre = 0.5 * (low + high);
  for (const Solid& part : parts) {
    const Vec3 d = part.ball().centre - ball.centre;
    ball.radius = std::max(ball.radius, std::sqrt(dot(d, d)) + part.ball().radius);
  }
  const Vec3 half = high - ball.centre;
  ball.radius = std::min(ball.radius, std::sqrt(dot(half, half))) + 1e-9;
  return ball;
}

}  // namespace

RayBody::RayBody(std::vector<Solid> parts) : parts_(std::move(parts)), ball_(around(parts_)) {}
RayBody::RayBody(std::shared_ptr<const TriangleMesh> mesh) : mesh_(std::move(mesh)), ball_(mesh_->ball()) {}

Result<RayBody> RayBody::create(const proto::ObjectBundle& object) {
  if (object.has_visual()) {
    auto mesh = TriangleMesh::create(object.visual());
    if (!mesh) return fail(mesh.error().code, object.name() + ": " + mesh.error().message);
    return RayBody(std::move(*mesh));
  }
  std::vector<Solid> parts;
  for (const proto::ConvexPart& part : object.part()) {
    Result<Solid> solid = Solid::create(part);
    if (!solid) return fail(solid.error().code, object.name() + ": " + solid.error().message);
    parts.push_back(std::move(*solid));
  }
  if (parts.empty()) return fail(ErrorCode::kInvalid, object.name() + " has no parts");
  return RayBody(std::move(parts));
}

int RayBody::enter(const Ray& ray_B, double t_min, double* t) const {
  if (mesh_) return mesh_->enter(ray_B, t_min, t);
  int best = -1;
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (parts_[i].enter(ray_B, t_min, *t, t)) best = static_cast<int>(i);
  return best;
}

void RayBody::smooth() {
  if (mesh_) shading_ = std::make_shared<MeshShading>(*mesh_);
}

Vec3 RayBody::normal(const Ray& ray_B, double t, int element, double bevel_m) const {
  if (!mesh_) return parts_[static_cast<std::size_t>(element)].normal(ray_B.at(t), bevel_m);
  const Vec3 flat = mesh_->normal(element);
  const Vec3 n = shading_ && bevel_m > 0 ? shading_->normal(*mesh_, element, ray_B.at(t)) : flat;
  return dot(flat, ray_B.direction) > 0 ? Vec3(-n) : n;
}

PosedScene::PosedScene(const RayCaster& caster, std::span<const Pose> X_WB,
                       std::span<const std::uint8_t> present, std::span<const double> scale)
    : caster_(&caster) {
  placed_.reserve(X_WB.size());
  for (std::size_t i = 0; i < X_WB.size(); ++i) {
    if (!present.empty() && !present[i]) continue;
    const BoundingBall& ball = caster.bodies()[i].ball();
    const double s = i < scale.size() ? scale[i] : 1;
    placed_.push_back({static_cast<int>(i),
                       X_WB[i].inverse(),
                       1 / s,
                       {X_WB[i] * Vec3(s * ball.centre), s * ball.radius + 1e-9}});
  }
  for (const Placed& placed : placed_)
    all_W_.centre += placed.ball_W.centre / static_cast<double>(placed_.size());
  for (const Placed& placed : placed_) {
    const Vec3 d = placed.ball_W.centre - all_W_.centre;
    all_W_.radius = std::max(all_W_.radius, std::sqrt(dot(d, d)) + placed.ball_W.radius + 1e-9);
  }
}

Ray PosedScene::to_body(const Ray& ray_W, std::size_t i) const {
  // Origin and direction shrink alike: the ray's parameter stays the depth in the world.
  const Pose& X_BW = placed_[i].X_BW;
  const double shrink = placed_[i].shrink;
  return {shrink * (X_BW * ray_W.origin), shrink * (X_BW.rotation * ray_W.direction)};
}

Hit PosedScene::meets_table(const Ray& ray_W, double t_min, double t_max) const {
  if (ray_W.direction.z() == 0) return {t_max, kNothing, 0};
  const double t = -ray_W.origin.z() / ray_W.direction.z();
  const double half = caster_->table_half();
  if (t > t_min && t < t_max && std::fabs(ray_W.origin.x() + t * ray_W.direction.x()) <= half &&
      std::fabs(ray_W.origin.y() + t * ray_W.direction.y()) <= half)
    return {t, kTable, 0};
  return {t_max, kNothing, 0};
}

Hit PosedScene::cast(const Ray& ray_W, double t_min, double t_max) const {
  Hit hit = meets_table(ray_W, t_min, t_max);
  if (!all_W_.touches(ray_W)) return hit;
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    if (!placed_[i].ball_W.touches(ray_W)) continue;
    const RayBody& body = caster_->bodies()[static_cast<std::size_t>(placed_[i].index)];
    const int element = body.enter(to_body(ray_W, i), t_min, &hit.t);
    if (element >= 0) hit.body = placed_[i].index, hit.element = element;
  }
  return hit;
}

bool PosedScene::blocked(const Ray& ray_W, double t_min, double t_max) const {
  const bool near_any = all_W_.touches(ray_W);
  for (std::size_t i = 0; near_any && i < placed_.size(); ++i) {
    if (!placed_[i].ball_W.touches(ray_W)) continue;
    double t = t_max;
    if (caster_->bodies()[static_cast<std::size_t>(placed_[i].index)].enter(to_body(ray_W, i), t_min, &t) >=
        0)
      return true;
  }
  return meets_table(ray_W, t_min, t_max).body != kNothing;
}

Vec3 PosedScene::normal(const Ray& ray_W, const Hit& hit, double bevel_m) const {
  if (hit.body < 0) return Vec3(0, 0, ray_W.direction.z() > 0 ? -1 : 1);
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    if (placed_[i].index != hit.body) continue;
    const RayBody& body = caster_->bodies()[static_cast<std::size_t>(hit.body)];
    return placed_[i].X_BW.rotation.transpose() * body.normal(to_body(ray_W, i), hit.t, hit.element, bevel_m);
  }
  return Vec3(0, 0, 1);
}

}  // namespace evograsp::sim

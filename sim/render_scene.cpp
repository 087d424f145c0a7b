#include "sim/render_scene.h"

#include <cmath>
#include <map>
#include <sstream>

#include "common/det_math.h"
#include "sim/scaled.h"

namespace evograsp::sim {
namespace {

constexpr double kDot = 0.0022;        // m, radius of a contact's dot
constexpr double kConeLength = 0.013;  // m
constexpr int kConeSides = 28;

// Muted colours that stay apart, also in grey.
const Vec3 kPalette[] = {Vec3(0.80, 0.20, 0.11), Vec3(0.04, 0.36, 0.42), Vec3(0.80, 0.46, 0.06),
                         Vec3(0.22, 0.34, 0.12), Vec3(0.13, 0.16, 0.42), Vec3(0.44, 0.12, 0.28),
                         Vec3(0.55, 0.50, 0.40), Vec3(0.06, 0.42, 0.28)};
const Vec3 kPalm(0.13, 0.14, 0.16);
const Vec3 kLinks[] = {Vec3(0.34, 0.36, 0.39), Vec3(0.46, 0.48, 0.51), Vec3(0.10, 0.105, 0.115)};
const Vec3 kDotColour(0.95, 0.10, 0.02);
const Vec3 kConeColour(1.00, 0.62, 0.05);

Result<std::vector<Solid>> solids_of(const google::protobuf::RepeatedPtrField<proto::ConvexPart>& parts) {
  std::vector<Solid> out;
  for (const proto::ConvexPart& part : parts) {
    Result<Solid> solid = Solid::create(part);
    if (!solid) return tl::unexpected(solid.error());
    out.push_back(std::move(*solid));
  }
  return out;
}

// How many links lie between a link and the palm: colours alternate along a finger.
int distance_to_palm(const proto::HandBundle& hand, int link) {
  int steps = 0;
  while (link > 0 && steps < 64) {
    link = static_cast<int>(hand.joint(link - 1).parent_link());
    ++steps;
  }
  return steps;
}
bool is_tip(const proto::HandBundle& hand, int link) {
  for (const proto::HandBundle::Joint& joint : hand.joint())
    if (static_cast<int>(joint.parent_link()) == link) return false;
  return true;
}

// A frame whose z axis is `axis`.
Mat3 frame_along(const Vec3& axis) {
  const Vec3 side = std::fabs(axis.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY();
  Mat3 frame;
  frame.col(2) = axis;
  frame.col(0) = side.cross(axis).normalized();
  frame.col(1) = axis.cross(Vec3(frame.col(0)));
  return frame;
}

Result<RayBody> cone(double mu) {
  proto::ConvexPart part;
  proto::ConvexPart::Hull* hull = part.mutable_hull();
  for (int k = 0; k < 3; ++k) hull->add_xyz(0);
  for (int i = 0; i < kConeSides; ++i) {
    double s = 0, c = 0;
    det::sincos(2 * det::kPi * i / kConeSides, &s, &c);
    hull->add_xyz(mu * kConeLength * c), hull->add_xyz(mu * kConeLength * s), hull->add_xyz(kConeLength);
  }
  Result<Solid> solid = Solid::create(part);
  if (!solid) return tl::unexpected(solid.error());
  return RayBody(std::vector<Solid>{std::move(*solid)});
}

RayBody dot() {
  proto::ConvexPart part;
  part.mutable_ball()->set_radius(kDot);
  return RayBody(std::vector<Solid>{*Solid::create(part)});
}

}  // namespace

std::vector<Pose> link_poses(const proto::HandBundle& hand, const Pose& X_WH,
                             std::span<const double> joints) {
  std::vector<Pose> out(static_cast<std::size_t>(hand.link_size()));
  if (out.empty()) return out;
  out[0] = X_WH;
  for (int i = 0; i < hand.joint_size() && i + 1 < hand.link_size(); ++i) {
    const proto::HandBundle::Joint& joint = hand.joint(i);
    const std::size_t parent = std::min<std::size_t>(joint.parent_link(), static_cast<std::size_t>(i));
    const double q = static_cast<std::size_t>(i) < joints.size() ? joints[static_cast<std::size_t>(i)]
                     : i < hand.preset_size()                    ? hand.preset(i)
                                                                 : 0;
    const Vec3 axis = from_proto(joint.axis());
    Pose motion;
    if (joint.prismatic()) {
      motion.position = q * axis;
    } else {
      motion.rotation = axis_angle(axis, q);
    }
    out[static_cast<std::size_t>(i) + 1] = out[parent] * from_proto(joint.origin()) * motion;
  }
  return out;
}

Status add_objects(RenderScene& scene, std::span<const proto::ObjectBundle> objects,
                   const Placements& placements) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (i >= placements.pose.size() || !placements.present[i]) continue;
    Result<RayBody> body = RayBody::create(scaled(objects[i], placements.scale_of(i)));
    if (!body) return tl::unexpected(body.error());
    body->smooth();
    scene.solid.push_back(
        {std::move(*body), placements.pose[i], {kPalette[i % std::size(kPalette)], 0.35, 1, 0.0012}});
  }
  return {};
}

Status add_hand(RenderScene& scene, const proto::HandBundle& hand, const Pose& X_WH,
                std::span<const double> joints) {
  const std::vector<Pose> poses = link_poses(hand, X_WH, joints);
  for (int i = 0; i < hand.link_size(); ++i) {
    Result<std::vector<Solid>> solids = solids_of(hand.link(i).part());
    if (!solids)
      return fail(solids.error().code, "hand link " + hand.link(i).name() + ": " + solids.error().message);
    if (solids->empty()) continue;
    const Vec3 colour = i == 0 ? kPalm : is_tip(hand, i) ? kLinks[2] : kLinks[distance_to_palm(hand, i) % 2];
    scene.solid.push_back(
        {RayBody(std::move(*solids)), poses[static_cast<std::size_t>(i)], {colour, 0.55, 1, 0.0025}});
  }
  return {};
}

Status add_contacts(RenderScene& scene, std::span<const Contact> contacts) {
  for (const Contact& contact : contacts) {
    const Mat3 frame = frame_along(contact.normal);
    scene.glass.push_back({dot(), {frame, contact.point}, {kDotColour, 0, 0.95, 0}});
    if (!(contact.mu > 0.01)) continue;
    Result<RayBody> shape = cone(std::min(contact.mu, 3.0));
    if (!shape) return tl::unexpected(shape.error());
    scene.glass.push_back({std::move(*shape), {frame, contact.point}, {kConeColour, 0, 0.38, 0}});
  }
  return {};
}

Subject subject_of(std::span<const proto::ObjectBundle> objects, const Placements& placements) {
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (i >= placements.pose.size() || !placements.present[i]) continue;
    const Vec3& at = placements.pose[i].position;
    const Vec3 reach = Vec3::Constant(placements.scale_of(i) * objects[i].footprint_radius());
    low = low.cwiseMin(at - reach), high = high.cwiseMax(at + reach);
  }
  if (!(low.x() <= high.x())) return {};
  return {0.5 * (low + high), std::max(0.09, 0.5 * (high - low).norm())};
}

Result<Camera> choose_view(const std::string& view, const Camera& depth_camera, const Subject& subject,
                           int width, int height) {
  constexpr double kFieldOfView = 0.42;  // rad
  if (view == "camera") return depth_camera.resized(width, height);
  static const std::map<std::string, Vec3> kNamed = {{"corner", Vec3(-0.40, -0.55, 0.36)},
                                                     {"front", Vec3(0.75, 0, 0.22)},
                                                     {"side", Vec3(0, -0.75, 0.22)},
                                                     {"top", Vec3(0, 0, 0.78)}};
  const double narrow = std::max(1.0, static_cast<double>(height) / width);
  if (const auto named = kNamed.find(view); named != kNamed.end()) {
    // From 0.77 m a ball of 14 cm fills the height of this field of view.
    const Vec3 eye = subject.centre + named->second * (subject.radius / 0.14) * narrow;
    return Camera::look_at(eye, subject.centre, width, height, kFieldOfView);
  }
  std::istringstream in(view);
  Vec3 eye;
  std::string rest;
  if (!(in >> eye.x() >> eye.y() >> eye.z()) || (in >> rest) || !is_finite(eye) || eye.norm() > 100 ||
      !((eye - subject.centre).norm() > 0.01))
    return fail(ErrorCode::kUsage, "unknown view '" + view +
                                       "': corner, front, side, top, camera, or an eye \"x y z\" in metres");
  return Camera::look_at(eye, subject.centre, width, height, kFieldOfView);
}

}  // namespace evograsp::sim

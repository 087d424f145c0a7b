#include "sim/scaled.h"

#include "common/pose.h"

namespace evograsp::sim {
namespace {

void scale_part(double s, proto::ConvexPart& part) {
  *part.mutable_pose()->mutable_position() = to_proto(Vec3(s * from_proto(part.pose().position())));
  part.set_rounding(s * part.rounding());
  if (part.has_box()) {
    proto::ConvexPart::Box& box = *part.mutable_box();
    box.set_hx(s * box.hx()), box.set_hy(s * box.hy()), box.set_hz(s * box.hz());
  }
  if (part.has_ball()) part.mutable_ball()->set_radius(s * part.ball().radius());
  for (proto::ConvexPart::Rod* rod : {part.has_cylinder() ? part.mutable_cylinder() : nullptr,
                                      part.has_capsule() ? part.mutable_capsule() : nullptr}) {
    if (rod == nullptr) continue;
    rod->set_radius(s * rod->radius());
    rod->set_half_length(s * rod->half_length());
  }
  if (part.has_hull()) {
    for (double& v : *part.mutable_hull()->mutable_xyz()) v *= s;
  }
}

}  // namespace

proto::ObjectBundle scaled(proto::ObjectBundle object, double size, double density) {
  if (size == 1 && density == 1) return object;
  for (proto::ConvexPart& part : *object.mutable_part()) scale_part(size, part);
  if (object.has_visual()) {
    for (float& v : *object.mutable_visual()->mutable_xyz()) v = static_cast<float>(size * v);
  }
  const double volume = size * size * size;
  object.set_mass(density * volume * object.mass());
  *object.mutable_centre_of_mass() = to_proto(Vec3(size * from_proto(object.centre_of_mass())));
  for (double& v : *object.mutable_inertia()) v *= density * volume * size * size;
  for (proto::RestingPose& resting : *object.mutable_resting()) resting.set_height(size * resting.height());
  object.set_torque_scale(size * object.torque_scale());
  object.set_footprint_radius(size * object.footprint_radius());
  return object;
}

}  // namespace evograsp::sim

#include "worker/steps.h"

#include <utility>

#include "worker/evaluator.h"

namespace evograsp::worker {

namespace {

Status shuffle(const sim::Simulator& simulator, const proto::StepRequest& request, proto::StepReply& reply) {
  const auto placements = simulator.shuffle(request.shuffle().seed());
  if (!placements) return tl::unexpected(placements.error());
  for (std::size_t i = 0; i < placements->pose.size(); ++i) {
    proto::Placement& object = *reply.mutable_placements()->add_object();
    object.set_name(simulator.object(static_cast<int>(i)).name());
    *object.mutable_pose() = evograsp::to_proto(placements->pose[i]);
    object.set_resting(placements->resting[i]);
    object.set_present(placements->present[i] != 0);
    if (placements->scale_of(i) != 1) object.set_scale(placements->scale_of(i));
  }
  return {};
}

// The scene and target that a client's get_info or get_quality is about.
Result<sim::Placements> scene_of(const sim::Simulator& simulator, const proto::StepRequest& request,
                                 std::uint32_t target) {
  if (!request.has_seed()) return fail(ErrorCode::kUsage, "no scene yet: shuffle first");
  if (target >= static_cast<std::uint32_t>(simulator.object_count()))
    return fail(ErrorCode::kNotFound, "no object " + std::to_string(target) + ": the scene has " +
                                          std::to_string(simulator.object_count()));
  auto placements = simulator.shuffle(request.seed());
  if (placements && placements->present[target] == 0)
    return fail(ErrorCode::kNotFound, "object " + std::to_string(target) + " does not stand in this scene");
  return placements;
}

Status get_info(const sim::Simulator& simulator, const proto::StepRequest& request, proto::StepReply& reply) {
  const proto::GetInfo& wanted = request.get_info();
  const auto placements = scene_of(simulator, request, wanted.target());
  if (!placements) return tl::unexpected(placements.error());
  const auto info = simulator.get_info(*placements, static_cast<int>(wanted.target()),
                                       static_cast<int>(wanted.click()), wanted.bounding_box());
  if (!info) return tl::unexpected(info.error());
  proto::Info& out = *reply.mutable_info();
  out.mutable_depth()->Add(info->depth.begin(), info->depth.end());
  out.set_click_a(info->click_a);
  out.set_click_b(info->click_b);
  out.set_box_w(info->box_w);
  out.set_box_h(info->box_h);
  *out.mutable_point() = evograsp::to_proto(info->point);
  *out.mutable_anchor() = evograsp::to_proto(info->anchor);
  out.mutable_feature()->Add(info->features.begin(), info->features.end());
  return {};
}

void describe(const sim::GraspReport& report, proto::GraspReport& out) {
  for (const sim::Contact& contact : report.contacts) {
    proto::Contact& c = *out.add_contact();
    *c.mutable_point() = evograsp::to_proto(contact.point);
    *c.mutable_normal() = evograsp::to_proto(contact.normal);
    c.set_mu(contact.mu);
    c.set_link(static_cast<std::uint32_t>(contact.link));
    c.set_part(static_cast<std::uint32_t>(contact.part));
    c.set_gap(contact.gap);
  }
  out.mutable_joint()->Add(report.joints.begin(), report.joints.end());
  *out.mutable_palm() = evograsp::to_proto(report.palm);
}

Status get_quality(const sim::Simulator& simulator, sim::Workspace& workspace,
                   const proto::StepRequest& request, proto::StepReply& reply) {
  const auto placements = scene_of(simulator, request, request.target());
  if (!placements) return tl::unexpected(placements.error());
  const proto::GetQuality& wanted = request.get_quality();
  const Pose tool = evograsp::from_proto(wanted.pose());
  sim::GraspReport report;
  const sim::Measurement measurement = simulator.get_quality(
      *placements, static_cast<int>(request.target()), tool, workspace, wanted.details() ? &report : nullptr);
  *reply.mutable_grasp()->mutable_measurement() = to_proto(measurement);
  if (wanted.details()) describe(report, *reply.mutable_grasp());
  return {};
}

Status answer(const sim::Simulator& simulator, sim::Workspace& workspace, const proto::StepRequest& request,
              proto::StepReply& reply) {
  switch (request.command_case()) {
    case proto::StepRequest::kShuffle:
      return shuffle(simulator, request, reply);
    case proto::StepRequest::kGetInfo:
      return get_info(simulator, request, reply);
    case proto::StepRequest::kGetQuality:
      return get_quality(simulator, workspace, request, reply);
    case proto::StepRequest::COMMAND_NOT_SET:
      break;
  }
  return fail(ErrorCode::kInvalid, "a step without a command");
}

}  // namespace

void answer_step(const sim::Simulator& simulator, sim::Workspace& workspace,
                 const proto::StepRequest& request, proto::StepReply& reply) {
  try {
    if (const Status status = answer(simulator, workspace, request, reply); !status)
      reply.set_error(status.error().message);
  } catch (const std::exception& error) {
    reply.set_error(error.what());
  }
}

}  // namespace evograsp::worker

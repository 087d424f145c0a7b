// The three commands on a slot of a running master's workers.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "cli/sim_session.h"
#include "common/message_check.h"
#include "common/step_client.h"
#include "common/view_features.h"

namespace evograsp::cli {
namespace {

constexpr int kMostObjects = 256;

// What a master says is a stranger's word, as everything that follows.
Result<assets::ResolvedExperiment> fetch(StepClient& client, const std::string& endpoint) {
  assets::ResolvedExperiment what;
  what.experiment = client.experiment();
  if (Status ok = check_message(what.experiment, endpoint); !ok) return tl::unexpected(ok.error());
  if (what.experiment.object_id_size() > kMostObjects)
    return fail(ErrorCode::kInvalid, endpoint + ": has more objects than can be");
  for (const std::string& id : what.experiment.object_id()) {
    const auto packed = client.asset(id);
    if (!packed) return tl::unexpected(packed.error());
    auto object = assets::unpack_object(*packed, id);
    if (!object) return tl::unexpected(object.error());
    what.objects.push_back(std::move(*object));
  }
  const std::string& id = what.experiment.hand_id();
  const auto packed = client.asset(id);
  if (!packed) return tl::unexpected(packed.error());
  auto hand = assets::unpack_hand(*packed, id);
  if (!hand) return tl::unexpected(hand.error());
  what.hand = std::move(*hand);
  return what;
}

template <class Numbers>
bool are_finite(const Numbers& numbers) {
  return std::ranges::all_of(numbers, [](auto number) { return std::isfinite(number); });
}

Result<sim::Info> info_of(const proto::Info& info, const proto::CameraConfig& camera) {
  if (info.depth_size() != static_cast<int>(camera.columns() * camera.rows()))
    return fail(ErrorCode::kInvalid, "the slot saw another number of depth samples than the camera has");
  if (info.feature_size() != static_cast<int>(other_inputs(camera) - kClickAndBoxInputs))
    return fail(ErrorCode::kInvalid, "the slot saw another number of features than the camera has");
  if (!std::ranges::all_of(info.depth(), [](float depth) { return depth >= 0 && depth <= 1; }))
    return fail(ErrorCode::kInvalid, "the slot saw a depth sample out of the camera's range");
  sim::Info out;
  out.depth.assign(info.depth().begin(), info.depth().end());
  out.click_a = info.click_a();
  out.click_b = info.click_b();
  out.box_w = info.box_w();
  out.box_h = info.box_h();
  out.point = from_proto(info.point());
  out.anchor = from_proto(info.anchor());
  out.features.assign(info.feature().begin(), info.feature().end());
  if (!are_finite(std::array{out.click_a, out.click_b, out.box_w, out.box_h}) || !are_finite(out.features) ||
      !is_finite(out.point) || !is_finite(out.anchor))
    return fail(ErrorCode::kInvalid, "the slot saw what is no number");
  return out;
}

sim::Measurement measurement_of(const proto::Measurement& m) {
  sim::Measurement out;
  out.outcome = m.outcome();
  out.quality = m.quality();
  out.contacts = static_cast<int>(m.contacts());
  out.obstructions = static_cast<int>(m.obstructions());
  out.p = from_proto(m.p());
  out.s = from_proto(m.s());
  out.o = from_proto(m.o());
  out.nearest_object = m.nearest_object();
  out.target_distance = m.target_distance();
  out.theta = m.theta();
  return out;
}

bool all_finite(const sim::GraspReport& report) {
  const sim::Measurement& m = report.measurement;
  return are_finite(std::array{m.quality, m.nearest_object, m.target_distance, m.theta}) && is_finite(m.p) &&
         is_finite(m.s) && is_finite(m.o) && are_finite(report.joints) && is_finite(report.palm) &&
         std::ranges::all_of(report.contacts, [](const sim::Contact& c) {
           return is_finite(c.point) && is_finite(c.normal) && are_finite(std::array{c.mu, c.gap});
         });
}

Result<sim::GraspReport> report_of(const proto::GraspReport& grasp, const proto::HandBundle& hand) {
  if (grasp.joint_size() != hand.joint_size())
    return fail(ErrorCode::kInvalid, "the slot told " + std::to_string(grasp.joint_size()) +
                                         " joints of a hand that has " + std::to_string(hand.joint_size()));
  const auto links = static_cast<std::uint32_t>(hand.link_size());
  if (!std::ranges::all_of(grasp.contact(), [&](const auto& c) { return c.link() < links; }))
    return fail(ErrorCode::kInvalid, "the slot told a contact of a link that the hand does not have");
  sim::GraspReport out;
  out.measurement = measurement_of(grasp.measurement());
  for (const proto::Contact& c : grasp.contact())
    out.contacts.push_back({from_proto(c.point()), from_proto(c.normal()), c.mu(), static_cast<int>(c.link()),
                            static_cast<int>(c.part()), c.gap()});
  out.joints.assign(grasp.joint().begin(), grasp.joint().end());
  out.palm = from_proto(grasp.palm());
  if (!all_finite(out)) return fail(ErrorCode::kInvalid, "the slot measured what is no number");
  return out;
}

class RemoteSession : public SimSession {
 public:
  RemoteSession(StepClient client, assets::ResolvedExperiment experiment)
      : client_(std::move(client)), experiment_(std::move(experiment)) {}

  const assets::ResolvedExperiment& experiment() const override { return experiment_; }

  Result<sim::Placements> shuffle(std::uint64_t seed) override {
    proto::StepRequest request;
    request.mutable_shuffle()->set_seed(seed);
    const auto reply = client_.ask(std::move(request));
    if (!reply) return tl::unexpected(reply.error());
    const proto::Placements& placements = reply->placements();
    if (placements.object_size() != static_cast<int>(experiment_.objects.size()))
      return fail(ErrorCode::kInvalid, "the slot placed another number of objects than the experiment has");
    sim::Placements out;
    out.seed = seed;
    for (const proto::Placement& object : placements.object()) {
      out.pose.push_back(from_proto(object.pose()));
      out.resting.push_back(static_cast<std::uint8_t>(object.resting()));
      out.present.push_back(object.present() ? 1 : 0);
      out.scale.push_back(object.scale());
    }
    const auto sound = [](double scale) { return scale > 0 && scale < 1e3; };
    if (!std::ranges::all_of(out.pose, [](const Pose& pose) { return is_finite(pose); }) ||
        !std::ranges::all_of(out.scale, sound))
      return fail(ErrorCode::kInvalid, "the slot placed an object nowhere");
    return out;
  }

  Result<sim::Info> get_info(int target, int click, bool bounding_box) override {
    proto::StepRequest request;
    proto::GetInfo& wanted = *request.mutable_get_info();
    wanted.set_target(static_cast<std::uint32_t>(target));
    wanted.set_click(static_cast<std::uint32_t>(click));
    wanted.set_bounding_box(bounding_box);
    const auto reply = client_.ask(std::move(request));
    if (!reply) return tl::unexpected(reply.error());
    return info_of(reply->info(), experiment_.experiment.camera());
  }

  // The slot judges the target of the last get_info, whatever came of that.
  Result<sim::GraspReport> get_quality(int, const Pose& tool) override {
    proto::StepRequest request;
    *request.mutable_get_quality()->mutable_pose() = to_proto(tool);
    request.mutable_get_quality()->set_details(true);
    const auto reply = client_.ask(std::move(request));
    if (!reply) return tl::unexpected(reply.error());
    return report_of(reply->grasp(), experiment_.hand);
  }

 private:
  StepClient client_;
  assets::ResolvedExperiment experiment_;
};

}  // namespace

Result<std::unique_ptr<SimSession>> remote_session(const std::string& endpoint,
                                                   const std::optional<CurveKeys>& keys) {
  auto client = StepClient::connect(endpoint, keys);
  if (!client) return tl::unexpected(client.error());
  auto experiment = fetch(*client, endpoint);
  if (!experiment) return tl::unexpected(experiment.error());
  return std::make_unique<RemoteSession>(std::move(*client), std::move(*experiment));
}

}  // namespace evograsp::cli

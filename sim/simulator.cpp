#include "sim/simulator.h"

#include <algorithm>
#include <cmath>

#include "common/det_math.h"
#include "common/message_check.h"
#include "common/view_features.h"
#include "sim/approach.h"
#include "sim/closing.h"
#include "sim/contacts.h"
#include "sim/decode.h"
#include "sim/depth.h"
#include "sim/friction.h"
#include "sim/hand.h"
#include "sim/hand_state.h"
#include "sim/quality.h"
#include "sim/scene.h"
#include "sim/view_features.h"
#include "sim/world.h"

namespace evograsp::sim {
namespace {

// Everything a trial scribbles on. The posed world is a cache keyed by the placements' every bit.
struct Slot final : Workspace {
  Slot(const HandModel& hand, const World& world, const ConeModel& cone, double min_quality)
      : state(hand), closing(hand, world.part_count()), quality(cone, min_quality) {
    approach.candidate.reserve(
        std::min<std::size_t>(hand.parts().size() * static_cast<std::size_t>(world.part_count()), 4096));
    approach.part_box.reserve(hand.parts().size());
    posed.obstacle.reserve(static_cast<std::size_t>(world.part_count()));
    contacts.reserve(256);
  }

  PosedWorld posed;
  HandState state;
  ApproachScratch approach;
  Closing closing;
  Quality quality;
  std::vector<Contact> contacts;
};

constexpr std::size_t kMaxObjects = 256;

// Positions beyond this are as good as infinite: squares of them would overflow.
constexpr double kFarAway = 1e9;  // m

bool usable(const Pose& tool) {
  return is_finite(tool) && tool.position.cwiseAbs().maxCoeff() < kFarAway;
}

// Degrees; 0 when either vector vanishes.
double angle(const Vec3& a, const Vec3& b) {
  const double lengths = std::sqrt(a.dot(a) * b.dot(b));
  return lengths > 0 ? det::acos(a.dot(b) / lengths) * (180 / det::kPi) : 0;
}

class GraspSimulator final : public Simulator {
 public:
  static Result<std::shared_ptr<const Simulator>> create(const proto::Experiment& experiment,
                                                         const std::vector<proto::ObjectBundle>& objects,
                                                         const proto::HandBundle& hand);

  std::unique_ptr<Workspace> make_workspace() const override {
    const proto::GraspConfig& grasp = experiment_.grasp();
    return std::make_unique<Slot>(*hand_model_, *world_,
                                  ConeModel{static_cast<int>(grasp.cone_edges()), grasp.unit_length_edges()},
                                  grasp.min_quality());
  }
  Result<Placements> shuffle(std::uint64_t seed) const override { return scene_->shuffle(seed); }
  Result<Info> get_info(const Placements& placements, int target, int click,
                        bool bounding_box) const override {
    return camera_->look(placements, target, click, bounding_box);
  }
  Measurement get_quality(const Placements& placements, int target, const Pose& tool, Workspace& workspace,
                          GraspReport* details) const override;
  Pose decode(std::span<const float> outputs, const Info& info, bool bounding_box) const override {
    return decode_pose(experiment_.grasp(), home_, outputs, info,
                       bounding_box || experiment_.camera().object_frame(),
                       pose_frame(experiment_.camera(), info.features));
  }

  int object_count() const override { return static_cast<int>(objects_.size()); }
  int inputs() const override { return static_cast<int>(network_inputs(experiment_.camera())); }
  const proto::Experiment& experiment() const override { return experiment_; }
  const proto::ObjectBundle& object(int index) const override {
    return objects_[static_cast<std::size_t>(index)];
  }
  const proto::HandBundle& hand() const override { return hand_; }

 private:
  GraspSimulator() = default;
  void attempt(const Placements& placements, int target, const Pose& tool, Slot& slot, Measurement& m) const;
  void measure(const Vec3& tool_point, const Slot& slot, Measurement& m) const;

  proto::Experiment experiment_;
  std::vector<proto::ObjectBundle> objects_;
  proto::HandBundle hand_;
  std::unique_ptr<const HandModel> hand_model_;
  std::unique_ptr<const World> world_;
  std::unique_ptr<const Scene> scene_;
  std::unique_ptr<const DepthCamera> camera_;
  Friction friction_;
  Mat3 home_ = Mat3::Identity();
};

template <class T>
Status keep(Result<T>&& made, std::unique_ptr<const T>& place) {
  if (!made) return tl::unexpected(made.error());
  place = std::make_unique<const T>(std::move(*made));
  return {};
}

Status check_ranges(const proto::Experiment& experiment) {
  if (Status ok = check_message(experiment, "experiment"); !ok) return ok;
  const proto::GraspConfig& g = experiment.grasp();
  const auto in = [](double v, double lo, double hi) { return v >= lo && v <= hi; };
  if (!in(g.contact_tolerance(), 1e-6, 0.01))
    return fail(ErrorCode::kInvalid, "grasp.contact_tolerance: out of range");
  if (!in(g.contact_margin(), 0, 0.02))
    return fail(ErrorCode::kInvalid, "grasp.contact_margin: out of range");
  if (!in(g.cone_edges(), 3, 64)) return fail(ErrorCode::kInvalid, "grasp.cone_edges: out of range");
  if (!in(g.wrist_reach(), 0, 1e3)) return fail(ErrorCode::kInvalid, "grasp.wrist_reach: out of range");
  if (!in(experiment.scene().default_friction(), 0, 10) || !in(experiment.scene().friction_jitter(), 0, 0.9))
    return fail(ErrorCode::kInvalid, "scene: friction out of range");
  if (!in(experiment.scene().table_half_size(), 0.05, 10))
    return fail(ErrorCode::kInvalid, "scene.table_half_size: out of range");
  return {};
}

Result<std::shared_ptr<const Simulator>> GraspSimulator::create(
    const proto::Experiment& experiment, const std::vector<proto::ObjectBundle>& objects,
    const proto::HandBundle& hand) {
  if (objects.empty()) return fail(ErrorCode::kInvalid, "experiment: no object in the scene");
  if (objects.size() > kMaxObjects)
    return fail(ErrorCode::kInvalid,
                "experiment: more than " + std::to_string(kMaxObjects) + " objects in the scene");
  std::shared_ptr<GraspSimulator> sim(new GraspSimulator);
  Status ok = check_ranges(experiment);
  if (ok) ok = keep(HandModel::create(hand, experiment.grasp().contact_tolerance()), sim->hand_model_);
  if (ok) ok = keep(World::create(experiment.scene(), objects), sim->world_);
  if (ok) ok = keep(DepthCamera::create(experiment, objects), sim->camera_);
  if (ok) ok = keep(Scene::create(experiment.scene(), sim->camera_->camera(), objects), sim->scene_);
  if (!ok) return tl::unexpected(ok.error());
  sim->friction_ = Friction(experiment.scene(), objects, *sim->hand_model_);
  sim->home_ = home_rotation(experiment.grasp(), hand);
  sim->experiment_ = experiment;
  sim->objects_ = objects;
  sim->hand_ = hand;
  return std::shared_ptr<const Simulator>(std::move(sim));
}

// Distances and theta, once the hand stands where it ends.
void GraspSimulator::measure(const Vec3& tool_point, const Slot& slot, Measurement& m) const {
  m.s = tool_point;
  m.target_distance = std::sqrt((m.o - m.s).dot(m.o - m.s));
  m.nearest_object = m.target_distance;
  for (const PosedWorld::Body& body : slot.posed.body) {
    const Vec3 d = body.centre_of_mass - m.s;
    if (body.present) m.nearest_object = std::min(m.nearest_object, std::sqrt(d.dot(d)));
  }
  const Pose& palm = slot.state.link[0];
  const Vec3 tip =
      slot.state.link[static_cast<std::size_t>(hand_model_->thumb_link())] * hand_model_->thumb_tip();
  const Vec3 to_thumb = tip - palm.position, to_target = m.o - palm.position;
  m.theta = angle(to_thumb, to_target) + angle(to_target, palm.rotation * hand_model_->finger_axis());
}

void GraspSimulator::attempt(const Placements& placements, int target, const Pose& tool, Slot& slot,
                             Measurement& m) const {
  const HandModel& hand = *hand_model_;
  const proto::GraspConfig& grasp = experiment_.grasp();
  const Vec3 direction = tool.rotation * hand.approach_axis();
  const double standoff = std::max(hand.standoff(), 1e-9);
  Pose palm{tool.rotation, tool * Vec3(-hand.tool_point())};
  const double from_origin = std::sqrt(palm.position.dot(palm.position));
  palm.position -= standoff * direction;
  slot.state.open(hand, palm);
  if (!(from_origin <= grasp.wrist_reach())) {
    m.outcome = proto::UNREACHABLE;
    return;
  }
  const double tolerance = grasp.contact_tolerance();
  const ApproachResult way =
      approach(hand, slot.state, slot.posed, direction, standoff, tolerance, slot.approach);
  if (way.blocked) {
    m.outcome = proto::BLOCKED;
    return;
  }
  palm.position += way.travelled * direction;
  slot.state.open(hand, palm);
  slot.closing.close(hand, slot.posed, tolerance, slot.state);
  m.obstructions =
      collect_contacts(hand, slot.state, slot.posed, target, grasp.contact_margin(), slot.contacts);
  for (Contact& c : slot.contacts) c.mu = friction_.mu(target, c.link, placements.seed);
  m.contacts = static_cast<int>(slot.contacts.size());
  m.outcome = m.contacts > 0 ? proto::GRASPED : proto::MISSED;
  m.quality =
      slot.quality(slot.contacts, m.o, slot.posed.body[static_cast<std::size_t>(target)].torque_scale);
}

Measurement GraspSimulator::get_quality(const Placements& placements, int target, const Pose& tool,
                                        Workspace& workspace, GraspReport* details) const {
  Slot& slot = static_cast<Slot&>(workspace);
  world_->place(placements, slot.posed);
  slot.contacts.clear();
  Measurement m;
  const bool known = target >= 0 && target < object_count();
  if (known) m.o = slot.posed.body[static_cast<std::size_t>(target)].centre_of_mass;
  if (!known || !usable(tool)) {
    m.outcome = known ? proto::NOT_A_NUMBER : proto::MISSED;
    slot.state.open(*hand_model_, Pose{});
  } else {
    m.p = tool.position;
    attempt(placements, target, tool, slot, m);
    measure(slot.state.link[0] * hand_model_->tool_point(), slot, m);
  }
  if (details != nullptr) {
    details->measurement = m;
    details->contacts = slot.contacts;
    details->joints = slot.state.value;
    details->palm = slot.state.link[0];
  }
  return m;
}

}  // namespace

Result<std::shared_ptr<const Simulator>> Simulator::create(const proto::Experiment& experiment,
                                                           const std::vector<proto::ObjectBundle>& objects,
                                                           const proto::HandBundle& hand) {
  return GraspSimulator::create(experiment, objects, hand);
}

}  // namespace evograsp::sim

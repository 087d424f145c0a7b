#include "sim/lift.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/det_math.h"
#include "common/random.h"
#include "sim/friction.h"
#include "sim/lift_world.h"
#include "sim/scaled.h"

namespace evograsp::sim {
namespace {

constexpr double kRestSpeed = 0.1;              // of a joint's own: slower fingers are at rest,
constexpr double kRestTime = 0.05;              // s: when they have been for so long
constexpr double kSettle = 0.1;                 // s: and not before
constexpr std::uint64_t kMassStream = 3000000;  // of the domain randomisation

Status check(const LiftSetup& setup, const LiftOptions& options) {
  const auto refuse = [](const std::string& why) { return fail(ErrorCode::kInvalid, "lift test: " + why); };
  const proto::HandBundle& hand = *setup.hand;
  const proto::ObjectBundle& object = *setup.object;
  if (hand.link_size() != hand.joint_size() + 1) return refuse("a hand needs one link more than joints");
  for (int j = 0; j < hand.joint_size(); ++j) {
    if (static_cast<int>(hand.joint(j).parent_link()) > j) return refuse("links must follow their parents");
  }
  for (const auto& motor : hand.motor()) {
    if (motor.joint_size() != motor.ratio_size()) return refuse("a motor needs one ratio a joint");
    for (const auto j : motor.joint()) {
      if (static_cast<int>(j) >= hand.joint_size()) return refuse("a motor moves a joint that is not there");
    }
  }
  if (static_cast<int>(setup.joints.size()) != hand.joint_size())
    return refuse("wrong number of joint values");
  if (static_cast<int>(setup.mu.size()) != hand.link_size()) return refuse("wrong number of friction values");
  for (double q : setup.joints) {
    if (!std::isfinite(q)) return refuse("a joint value is not finite");
  }
  if (!is_finite(setup.palm) || !is_finite(setup.object_pose)) return refuse("a pose is not finite");
  if (!(object.mass() > 0) || object.part_size() == 0 || object.inertia_size() != 6) {
    return refuse("object '" + object.name() + "' has no mass, no inertia or no parts");
  }
  if (!(options.step_s > 0) || !(options.lift_s > 0)) return refuse("a duration is not positive");
  return {};
}

// One test on its way through closing, lifting, holding and shaking.
class Run {
 public:
  Run(const LiftSetup& setup, const LiftOptions& options) : options_(options), world_(setup, options) {}

  LiftReport report() {
    close();
    lift();
    world_.remove_table();
    still(options_.hold_s);
    for (int axis = 0; axis < 3; ++axis) {
      shake(Vec3::Unit(axis));
      shake(-Vec3::Unit(axis));
    }
    report_.held = !lost() && world_.touches_hand();
    return report_;
  }

 private:
  bool lost() const { return report_.lost_at >= 0; }

  void close() {
    double rest = 0;
    while (report_.time < options_.close_s && !(rest >= kRestTime && report_.time >= kSettle)) {
      step(Vec3::Zero(), 0);
      rest = world_.fastest_joint() < kRestSpeed ? rest + options_.step_s : 0;
    }
    world_.hold_closed();
    closed_ = world_.object();
    closed_at_ = report_.time;
  }

  // z = h (1 - cos(pi t / T)) / 2: starts and ends at rest.
  void lift() {
    const double rate = det::kPi / options_.lift_s, half = options_.lift_m / 2;
    for (double t = 0; t < options_.lift_s && !lost(); t += options_.step_s) {
      double sine = 0, cosine = 0;
      det::sincos(rate * t, &sine, &cosine);
      step(Vec3(0, 0, half * rate * rate * cosine), half * rate * sine);
    }
  }

  void still(double seconds) {
    for (double t = 0; t < seconds && !lost(); t += options_.step_s) step(Vec3::Zero(), 0);
  }

  // x = a (1 - cos(2 pi t / T)) / 2 along a direction: out and back.
  void shake(const Vec3& direction) {
    const double rate = 2 * det::kPi / options_.shake_s;
    for (double t = 0; t < options_.shake_s && !lost(); t += options_.step_s) {
      step(options_.shake_m / 2 * rate * rate * det::cos(rate * t) * direction, 0);
    }
  }

  void step(const Vec3& acceleration, double table_speed) {
    world_.step(acceleration, table_speed);
    report_.time += options_.step_s;
    if (closed_) measure();
  }

  void measure() {
    const Pose now = world_.object();
    report_.slip = (now.position - closed_->position).norm();
    const double cosine = ((closed_->rotation.transpose() * now.rotation).trace() - 1) / 2;
    report_.turn = det::acos(std::clamp(cosine, -1.0, 1.0));
    if (!(report_.slip <= options_.max_slip_m)) report_.lost_at = report_.time - closed_at_;
    report_.max_displacement = std::max(report_.max_displacement, report_.slip);
  }

  LiftOptions options_;
  LiftReport report_;
  std::optional<Pose> closed_;  // the object when the hand had closed
  double closed_at_ = 0;
  LiftWorld world_;

 public:
  double joint(int index) const { return world_.joint(index); }
};

}  // namespace

Result<LiftReport> lift_test(const LiftSetup& setup, const LiftOptions& options) {
  if (auto status = check(setup, options); !status) return tl::unexpected(status.error());
  Run run(setup, options);
  LiftReport report = run.report();
  for (int j = 0; j < setup.hand->joint_size(); ++j) report.joints.push_back(run.joint(j));
  return report;
}

Result<LiftReport> lift_test(const Simulator& simulator, const Placements& placements, int target,
                             const GraspReport& attempt, const LiftOptions& options) {
  auto model = HandModel::create(simulator.hand());
  if (!model) return tl::unexpected(model.error());
  const proto::SceneConfig& scene = simulator.experiment().scene();
  std::vector<proto::ObjectBundle> objects;
  for (int i = 0; i < simulator.object_count(); ++i) objects.push_back(simulator.object(i));
  const Friction friction(scene, objects, *model);
  std::vector<double> mu;
  for (int l = 0; l < model->link_count(); ++l) mu.push_back(friction.mu(target, l, placements.seed));
  LiftSetup setup;
  setup.hand = &simulator.hand();
  setup.palm = attempt.palm;
  setup.joints = model->preset();
  double density = 1;
  if (scene.mass_jitter() > 0) {
    Random mass(placements.seed, Purpose::kDomain, 0, kMassStream + static_cast<std::uint64_t>(target));
    density = mass.uniform(1 - scene.mass_jitter(), 1 + scene.mass_jitter());
  }
  const proto::ObjectBundle object =
      scaled(simulator.object(target), placements.scale_of(static_cast<std::size_t>(target)), density);
  setup.object = &object;
  setup.object_pose = placements.pose[static_cast<std::size_t>(target)];
  setup.mu = mu;
  return lift_test(setup, options);
}

}  // namespace evograsp::sim

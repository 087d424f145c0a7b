#include "cli/sim_session.h"

namespace evograsp::cli {
namespace {

Pose cross(const Pose& pose) {
  return from_proto(to_proto(pose));
}

class LocalSession : public SimSession {
 public:
  LocalSession(assets::ResolvedExperiment experiment, std::shared_ptr<const sim::Simulator> simulator)
      : experiment_(std::move(experiment)),
        simulator_(std::move(simulator)),
        workspace_(simulator_->make_workspace()) {}

  const assets::ResolvedExperiment& experiment() const override { return experiment_; }

  Result<sim::Placements> shuffle(std::uint64_t seed) override {
    Result<sim::Placements> placements = simulator_->shuffle(seed);
    if (!placements) return placements;
    placements_ = *placements;
    for (Pose& pose : placements->pose) pose = cross(pose);
    return placements;
  }

  Result<sim::Info> get_info(int target, int click, bool bounding_box) override {
    return simulator_->get_info(placements_, target, click, bounding_box);
  }

  Result<sim::GraspReport> get_quality(int target, const Pose& tool) override {
    sim::GraspReport report;
    report.measurement = simulator_->get_quality(placements_, target, cross(tool), *workspace_, &report);
    report.palm = cross(report.palm);
    return report;
  }

 private:
  assets::ResolvedExperiment experiment_;
  std::shared_ptr<const sim::Simulator> simulator_;
  std::unique_ptr<sim::Workspace> workspace_;
  sim::Placements placements_;
};

}  // namespace

Result<std::unique_ptr<SimSession>> local_session(assets::ResolvedExperiment experiment) {
  auto simulator = sim::Simulator::create(experiment.experiment, experiment.objects, experiment.hand);
  if (!simulator) return tl::unexpected(simulator.error());
  return std::make_unique<LocalSession>(std::move(experiment), std::move(*simulator));
}

}  // namespace evograsp::cli

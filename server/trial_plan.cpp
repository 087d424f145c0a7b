#include "server/trial_plan.h"

#include "common/random.h"
#include "common/scene_subset.h"

namespace evograsp::server {

namespace {

constexpr std::uint64_t kSetName = ~std::uint64_t{0};  // an index no placement has

std::vector<std::uint32_t> targets_of(const proto::SceneConfig& scene, std::uint64_t seed) {
  const auto present =
      scene_subset(seed, static_cast<std::uint32_t>(scene.object_size()), scene.objects_in_scene());
  std::vector<std::uint32_t> targets;
  for (std::uint32_t i = 0; i < present.size(); ++i)
    if (present[i] != 0) targets.push_back(i);
  return targets;
}

void add(TrialPlan& plan, std::uint64_t seed, std::uint32_t target, std::uint32_t click) {
  proto::TrialKey& key = plan.trials.emplace_back();
  key.set_seed(seed);
  key.set_target(target);
  key.set_click(click);
}

// Part 0 are the mandatory scenes of a generation, part 1 and on the optional ones.
TrialPlan plan_scenes(const proto::Config& config, std::uint32_t generation, std::uint32_t part) {
  const std::uint64_t run = config.run().seed();
  TrialPlan plan;
  plan.set = hash_key(run, Purpose::kTrialSeeds, generation, kSetName - part);
  const std::uint64_t first = std::uint64_t{part} * config.trials().scenes();
  for (std::uint32_t i = 0; i < config.trials().scenes(); ++i) {
    Random random(run, Purpose::kTrialSeeds, generation, first + i);
    const std::uint64_t seed = random.next();
    std::vector<std::uint32_t> targets = targets_of(config.scene(), seed);
    if (!config.trials().every_object())
      targets = {targets[random.below(static_cast<std::uint32_t>(targets.size()))]};
    for (const std::uint32_t target : targets)
      for (std::uint32_t click = 0; click < config.trials().clicks(); ++click) add(plan, seed, target, click);
  }
  const bool mapped = part == 0 && config.neat().has_archive();
  if (mapped)
    for (proto::TrialKey& key : plan.trials) key.set_approach(true);
  return plan;
}

// Placements of one stream, a trial each; targets take turns among the objects that stand there.
TrialPlan plan_fresh(const proto::Config& config, Purpose purpose, std::uint32_t stream,
                     std::uint32_t trials) {
  const std::uint64_t run = config.run().seed();
  TrialPlan plan;
  plan.set = hash_key(run, purpose, stream, kSetName);
  for (std::uint32_t i = 0; i < trials; ++i) {
    Random random(run, purpose, stream, i);
    const std::uint64_t seed = random.next();
    const std::vector<std::uint32_t> targets = targets_of(config.scene(), seed);
    add(plan, seed, targets[i % targets.size()], 0);
  }
  return plan;
}

}  // namespace

TrialPlan plan_generation(const proto::Config& config, std::uint32_t generation) {
  return plan_scenes(config, generation, 0);
}

TrialPlan plan_optional(const proto::Config& config, std::uint32_t generation, std::uint32_t round) {
  TrialPlan plan = plan_scenes(config, generation, round + 1);
  plan.stage = "race " + std::to_string(round + 1);
  return plan;
}

TrialPlan plan_validation(const proto::Config& config) {
  return plan_fresh(config, Purpose::kValidation, 0, config.champion().validation_trials());
}

TrialPlan plan_final_lifts(const proto::Config& config) {
  TrialPlan plan = plan_fresh(config, Purpose::kValidation, 1, config.lift().finalist_trials());
  plan.stage = "final lift";
  for (proto::TrialKey& key : plan.trials) key.set_lift(true);
  return plan;
}

TrialPlan plan_lifts(const proto::Config& config, std::uint32_t generation) {
  TrialPlan plan = plan_fresh(config, Purpose::kLifts, generation, config.lift().trials());
  plan.stage = "lift";
  for (proto::TrialKey& key : plan.trials) key.set_lift(true);
  return plan;
}

}  // namespace evograsp::server

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

}  // namespace

TrialPlan plan_generation(const proto::Config& config, std::uint32_t generation) {
  const std::uint64_t run = config.run().seed();
  TrialPlan plan;
  plan.set = hash_key(run, Purpose::kTrialSeeds, generation, kSetName);
  for (std::uint32_t scene = 0; scene < config.trials().scenes(); ++scene) {
    Random random(run, Purpose::kTrialSeeds, generation, scene);
    const std::uint64_t seed = random.next();
    std::vector<std::uint32_t> targets = targets_of(config.scene(), seed);
    if (!config.trials().every_object())
      targets = {targets[random.below(static_cast<std::uint32_t>(targets.size()))]};
    for (const std::uint32_t target : targets)
      for (std::uint32_t click = 0; click < config.trials().clicks(); ++click) add(plan, seed, target, click);
  }
  return plan;
}

TrialPlan plan_validation(const proto::Config& config) {
  const std::uint64_t run = config.run().seed();
  TrialPlan plan;
  plan.set = hash_key(run, Purpose::kValidation, 0, kSetName);
  for (std::uint32_t i = 0; i < config.champion().validation_trials(); ++i) {
    Random random(run, Purpose::kValidation, 0, i);
    const std::uint64_t seed = random.next();
    const std::vector<std::uint32_t> targets = targets_of(config.scene(), seed);
    add(plan, seed, targets[i % targets.size()], 0);
  }
  return plan;
}

}  // namespace evograsp::server

// Which trials a generation has, and which network a run gives out.
#include "server/champion.h"

#include <gtest/gtest.h>

#include <set>

#include "common/scene_subset.h"
#include "server/trial_plan.h"

namespace evograsp::server {
namespace {

proto::Config config_of(int objects, std::uint32_t in_scene, bool every) {
  proto::Config config;
  config.mutable_run()->set_seed(5);
  for (int i = 0; i < objects; ++i) config.mutable_scene()->add_object("object");
  config.mutable_scene()->set_objects_in_scene(in_scene);
  config.mutable_trials()->set_scenes(4);
  config.mutable_trials()->set_clicks(3);
  config.mutable_trials()->set_every_object(every);
  config.mutable_champion()->set_validation_trials(9);
  return config;
}

TEST(TrialPlan, IsScenesTimesObjectsTimesClicks) {
  EXPECT_EQ(plan_generation(config_of(4, 0, true), 0).trials.size(), 4U * 4 * 3);
  EXPECT_EQ(plan_generation(config_of(4, 0, false), 0).trials.size(), 4U * 1 * 3);
  EXPECT_EQ(plan_generation(config_of(4, 2, true), 0).trials.size(), 4U * 2 * 3);
}

TEST(TrialPlan, TargetsStandInTheirScene) {
  const proto::Config config = config_of(6, 2, true);
  for (std::uint32_t generation = 0; generation < 20; ++generation)
    for (const proto::TrialKey& key : plan_generation(config, generation).trials)
      EXPECT_EQ(scene_subset(key.seed(), 6, 2)[key.target()], 1);
}

TEST(TrialPlan, GenerationsAndValidationShareNoPlacement) {
  const proto::Config config = config_of(1, 0, true);
  std::set<std::uint64_t> seeds, sets;
  for (std::uint32_t generation = 0; generation < 50; ++generation) {
    const TrialPlan plan = plan_generation(config, generation);
    EXPECT_TRUE(sets.insert(plan.set).second);
    for (const proto::TrialKey& key : plan.trials)
      if (key.click() == 0) {
        EXPECT_TRUE(seeds.insert(key.seed()).second);
      }
  }
  const TrialPlan validation = plan_validation(config);
  EXPECT_EQ(validation.trials.size(), 9U);
  for (const proto::TrialKey& key : validation.trials) EXPECT_TRUE(seeds.insert(key.seed()).second);
}

TEST(Champion, LiftedOnesComeFirstByGraspsAndLifts) {
  // 38 of 40 and 10 of 20 lifted; 36 of 40 and 18 of 20; 40 of 40 and never lifted.
  EXPECT_EQ(choose({{1, 10, 40, 38, 0.9, 20, 10}, {2, 11, 40, 36, 0.8, 20, 18}, {3, 12, 40, 40, 1.0, 0, 0}}),
            1U);
  // Lifting does not excuse bad grasps: 40 + 19 beats 20 + 20.
  EXPECT_EQ(choose({{1, 10, 40, 40, 0.9, 20, 19}, {2, 11, 40, 20, 0.9, 20, 20}}), 0U);
  EXPECT_EQ(ranking({{1, 10, 40, 30, 0.9}, {2, 11, 40, 35, 0.5}, {3, 12, 40, 32, 0.5}}),
            (std::vector<std::size_t>{1, 2, 0}));
}

TEST(TrialPlan, LiftsHavePlacementsOfTheirOwn) {
  proto::Config config = config_of(1, 0, true);
  config.mutable_lift()->set_trials(3);
  config.mutable_lift()->set_finalist_trials(7);
  std::set<std::uint64_t> seeds;
  std::size_t drawn = 0;
  const auto take = [&](const TrialPlan& plan, bool lift) {
    for (const proto::TrialKey& key : plan.trials) {
      EXPECT_EQ(key.lift(), lift);
      seeds.insert(key.seed());
    }
    drawn += plan.trials.size();
  };
  config.mutable_trials()->set_clicks(1);
  for (std::uint32_t generation = 0; generation < 20; ++generation) {
    take(plan_generation(config, generation), false);
    take(plan_lifts(config, generation), true);
  }
  take(plan_validation(config), false);
  take(plan_final_lifts(config), true);
  EXPECT_EQ(drawn, 20U * (4 + 3) + 9 + 7);
  EXPECT_EQ(seeds.size(), drawn);
}

TEST(Champion, MostSuccessesThenFitnessThenTheEarlier) {
  EXPECT_EQ(choose({{1, 10, 40, 30, 0.9}, {2, 11, 40, 31, 0.5}}), 1U);
  EXPECT_EQ(choose({{1, 10, 40, 31, 0.4}, {2, 11, 40, 31, 0.5}}), 1U);
  EXPECT_EQ(choose({{3, 10, 40, 31, 0.5}, {2, 11, 40, 31, 0.5}}), 1U);
}

TEST(Champion, AnEliteThatStayedBestIsOneCandidate) {
  const std::vector<BestRecord> bests = {
      {1, 7, 0.5, "g", "same"}, {2, 8, 0.4, "h", "other"}, {3, 7, 0.6, "g", "same"}};
  const auto kept = candidates(bests);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].generation, 1U);
}

}  // namespace
}  // namespace evograsp::server

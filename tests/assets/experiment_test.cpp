// A config's experiment: defaults written out, ids and fingerprint that follow the content.
#include <gtest/gtest.h>

#include "assets/assets.h"
#include "common/pose.h"

namespace evograsp::assets {
namespace {

proto::Config cube_config() {
  proto::Config config;
  config.mutable_scene()->add_object("cube");
  return config;
}

TEST(Experiment, WritesOutEveryDefault) {
  const auto resolved = resolve_experiment(cube_config(), {});
  ASSERT_TRUE(resolved) << resolved.error().message;
  const proto::Experiment& e = resolved->experiment;
  EXPECT_TRUE(e.camera().has_fx());
  EXPECT_DOUBLE_EQ(e.camera().fx(), 525);
  EXPECT_DOUBLE_EQ(e.camera().eye().x(), 0.55);
  EXPECT_DOUBLE_EQ(e.grasp().workspace_half().z(), 0.125);
  EXPECT_EQ(e.grasp().hand(), "meka_h2");
  EXPECT_TRUE(e.scene().has_placement_tries());
  EXPECT_TRUE(e.trials().has_every_object());
  EXPECT_FALSE(e.camera().has_noise()) << "absent means no noise";
  ASSERT_EQ(e.object_id_size(), 1);
  EXPECT_EQ(e.object_id(0), load_object("cube", {})->id);
  EXPECT_EQ(e.hand_id(), load_hand("meka_h2", {})->id);
  EXPECT_EQ(resolved->objects.size(), 1u);
}

TEST(Experiment, HomePointsTheApproachDownAndTheFingersToMinusX) {
  for (const char* hand : {"meka_h2", "parallel_jaw", "barrett"}) {
    proto::Config config = cube_config();
    config.mutable_grasp()->set_hand(hand);
    const auto resolved = resolve_experiment(config, {});
    ASSERT_TRUE(resolved) << resolved.error().message;
    const Mat3 home = from_proto(resolved->experiment.grasp().home().orientation());
    EXPECT_LT((home * from_proto(resolved->hand.approach_axis()) - Vec3(0, 0, -1)).norm(), 1e-12);
    EXPECT_LT((home * from_proto(resolved->hand.finger_axis()) - Vec3(-1, 0, 0)).norm(), 1e-12);
    EXPECT_NEAR(home.determinant(), 1, 1e-12);
  }
}

TEST(Experiment, FingerprintFollowsWhatATrialDependsOnAndNothingElse) {
  const auto fingerprint = [](const proto::Config& config) {
    const auto resolved = resolve_experiment(config, {});
    EXPECT_TRUE(resolved);
    return resolved ? resolved->experiment.fingerprint() : std::string();
  };
  const std::string plain = fingerprint(cube_config());
  EXPECT_EQ(plain.size(), 64u);
  proto::Config same = cube_config();
  same.mutable_camera()->set_fx(525);       // the default, spelled out
  same.mutable_fitness()->set_terms("13");  // never sent to workers
  same.mutable_run()->set_seed(9);
  EXPECT_EQ(fingerprint(same), plain);
  proto::Config other = cube_config();
  other.mutable_camera()->set_fx(526);
  EXPECT_NE(fingerprint(other), plain);
  other = cube_config();
  other.mutable_scene()->set_object(0, "cube_5cm");
  EXPECT_NE(fingerprint(other), plain);
}

TEST(Experiment, SaysWhichNameIsWrong) {
  proto::Config config = cube_config();
  config.mutable_scene()->add_object("mgu");
  auto resolved = resolve_experiment(config, {});
  ASSERT_FALSE(resolved);
  EXPECT_NE(resolved.error().message.find("scene.object: mgu"), std::string::npos)
      << resolved.error().message;
  config = cube_config();
  config.mutable_grasp()->set_hand("meka");
  resolved = resolve_experiment(config, {});
  ASSERT_FALSE(resolved);
  EXPECT_NE(resolved.error().message.find("grasp.hand: meka"), std::string::npos);
  EXPECT_FALSE(resolve_experiment(proto::Config(), {})) << "no object";
}

}  // namespace
}  // namespace evograsp::assets

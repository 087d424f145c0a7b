// A config's experiment: defaults written out, ids and fingerprint that follow the content.
#include "assets/experiment.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

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

TEST(Experiment, IsTheSameFromWhereverItsFilesAreNamed) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("evograsp_names_" + std::to_string(::getpid()));
  fs::create_directories(folder / "mine");
  std::ofstream(folder / "mine" / "box.txtpb") << "cuboid { x: 0.05 y: 0.04 z: 0.08 }\n";
  fs::copy_file(folder / "mine" / "box.txtpb", folder / "box.txtpb", fs::copy_options::overwrite_existing);
  const auto resolved = [](const std::string& object, const fs::path& base) {
    proto::Config config;
    config.mutable_scene()->add_object(object);
    auto made = resolve_experiment(config, base);
    EXPECT_TRUE(made) << made.error().message;
    return made ? made->experiment : proto::Experiment();
  };
  const proto::Experiment absolute = resolved((folder / "mine" / "box.txtpb").string(), {});
  EXPECT_EQ(absolute.scene().object(0), "box.txtpb");
  for (const proto::Experiment& other :
       {resolved("mine/box.txtpb", folder), resolved("box.txtpb", folder / "mine"),
        resolved("../mine/box.txtpb", folder / "mine"), resolved("box.txtpb", folder)}) {
    EXPECT_EQ(other.fingerprint(), absolute.fingerprint());
    EXPECT_EQ(other.SerializeAsString(), absolute.SerializeAsString());
  }
  std::ofstream(folder / "box.txtpb") << "cuboid { x: 0.05 y: 0.04 z: 0.09 }\n";
  EXPECT_NE(resolved("box.txtpb", folder).fingerprint(), absolute.fingerprint()) << "content decides";
  fs::remove_all(folder);
}

TEST(Experiment, TakesBundlesThatAreAtHand) {
  const auto cube = load_object("cube", {});
  const auto hand = load_hand("parallel_jaw", {});
  ASSERT_TRUE(cube && hand);
  proto::Config config;
  config.mutable_scene()->add_object("/gone/cube.ply");
  config.mutable_grasp()->set_hand("/gone/jaw.txtpb");
  const auto resolved = resolve_experiment(config, {}, Bundles{{cube->bundle}, hand->bundle});
  ASSERT_TRUE(resolved) << resolved.error().message;
  EXPECT_EQ(resolved->experiment.object_id(0), cube->id);
  EXPECT_EQ(resolved->experiment.hand_id(), hand->id);
  config.mutable_scene()->add_object("mug");
  EXPECT_FALSE(resolve_experiment(config, {}, Bundles{{cube->bundle}, hand->bundle}));
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

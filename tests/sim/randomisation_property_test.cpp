// Domain randomisation: sizes, masses and the camera's pose of a placement come from its seed alone, and a
// scaled object is, to the hand and to the camera, the object that was modelled at that size.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/depth.h"
#include "sim/friction.h"
#include "sim/lift.h"
#include "sim/scaled.h"
#include "sim/scene.h"
#include "tests/sim/digest.h"
#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

const std::vector<std::string> kObjects = {"cylinder", "cube", "mug", "bottle", "sphere"};

struct Scenes {
  assets::ResolvedExperiment resolved;
  std::shared_ptr<const Simulator> sim;
};

Scenes make(const std::vector<std::string>& objects, double size, double eye = 0, double aim = 0) {
  proto::Config config;
  for (const std::string& name : objects) config.mutable_scene()->add_object(name);
  config.mutable_scene()->set_size_jitter(size);
  config.mutable_scene()->set_objects_in_scene(1);
  config.mutable_camera()->set_eye_jitter(eye);
  config.mutable_camera()->set_aim_jitter(aim);
  Scenes out;
  out.resolved = *assets::resolve_experiment(config, EVOGRASP_SOURCE_DIR);
  out.sim = *Simulator::create(out.resolved.experiment, out.resolved.objects, out.resolved.hand);
  return out;
}

int target_of(const Placements& placements) {
  int target = 0;
  while (!placements.present[static_cast<std::size_t>(target)]) ++target;
  return target;
}

Pose tool_for(const Simulator& sim, const Placements& p, int target, std::uint64_t seed) {
  Random random(5, Purpose::kTestHarness, 0, seed);
  const auto t = static_cast<std::size_t>(target);
  const Vec3 centre = p.pose[t] * Vec3(p.scale_of(t) * from_proto(sim.object(target).centre_of_mass()));
  return testing::random_tool_pose(random, centre, 0.03);
}

TEST(Randomisation, SizesFillTheRangeAndComeFromTheSeed) {
  const Scenes a = make({"cylinder", "cube"}, 0.25);
  double least = 2, most = 0, sum = 0;
  constexpr int kSeeds = 500;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Placements once = *a.sim->shuffle(seed), again = *a.sim->shuffle(seed);
    EXPECT_EQ(once.scale, again.scale);
    ASSERT_EQ(once.scale.size(), 2u);
    EXPECT_NE(once.scale[0], once.scale[1]) << "each object has its own";
    for (const double s : once.scale) {
      least = std::min(least, s), most = std::max(most, s), sum += s;
      ASSERT_TRUE(s >= 0.75 && s < 1.25);
    }
  }
  EXPECT_LT(least, 0.76);
  EXPECT_GT(most, 1.24);
  EXPECT_NEAR(sum / (2 * kSeeds), 1, 0.02);
}

// The trial on a scaled object against the trial on a bundle that was made as large. Rounding apart they are
// the same, but a link may stop anywhere within the contact tolerance.
TEST(Randomisation, AScaledObjectIsTheObjectOfThatSize) {
  const Scenes jittered = make(kObjects, 0.3);
  const auto workspace = jittered.sim->make_workspace();
  int grasped = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    const Placements p = *jittered.sim->shuffle(seed);
    const int target = target_of(p);
    const auto t = static_cast<std::size_t>(target);
    std::vector<proto::ObjectBundle> objects = jittered.resolved.objects;
    objects[t] = scaled(objects[t], p.scale[t]);
    const auto plain = *Simulator::create(jittered.resolved.experiment, objects, jittered.resolved.hand);
    Placements as_modelled = p;
    as_modelled.scale.clear();
    const Pose tool = tool_for(*jittered.sim, p, target, seed);
    const auto other = plain->make_workspace();
    const Measurement a = jittered.sim->get_quality(p, target, tool, *workspace);
    const Measurement b = plain->get_quality(as_modelled, target, tool, *other);
    ASSERT_EQ(a.outcome, b.outcome) << "seed " << seed;
    ASSERT_NEAR((a.s - b.s).norm(), 0, 2e-4) << "seed " << seed;
    ASSERT_NEAR((a.o - b.o).norm(), 0, 1e-12);
    if (a.contacts == b.contacts) {
      ASSERT_NEAR(a.quality, b.quality, 0.02) << "seed " << seed;
    }
    grasped += a.outcome == proto::GRASPED ? 1 : 0;
    const Info one = *jittered.sim->get_info(p, target, 0, true);
    const Info two = *plain->get_info(as_modelled, target, 0, true);
    int apart = 0;
    for (std::size_t i = 0; i < one.depth.size(); ++i) apart += std::fabs(one.depth[i] - two.depth[i]) > 1e-5;
    ASSERT_LE(apart, 3) << "rays that graze an edge; seed " << seed;
    ASSERT_NEAR(one.box_w, two.box_w, 1e-6);
    ASSERT_NEAR((one.anchor - two.anchor).norm(), 0, 1e-5);
  }
  EXPECT_GT(grasped, 30);
}

TEST(Randomisation, ScaledObjectsRestOnTheTableInsideTheView) {
  const Scenes scenes = make(kObjects, 0.4, 0.05, 0.03);
  const Camera camera = *Camera::create(scenes.resolved.experiment.camera());
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Placements p = *scenes.sim->shuffle(seed);
    const int target = target_of(p);
    const auto t = static_cast<std::size_t>(target);
    const proto::ObjectBundle object = scaled(scenes.resolved.objects[t], p.scale[t]);
    double lowest = 1;
    std::vector<Solid> parts;
    for (const proto::ConvexPart& part : object.part()) {
      parts.push_back(*Solid::create(part));
      lowest = std::min(
          lowest, (p.pose[t] * parts.back().support(p.pose[t].rotation.transpose() * Vec3(0, 0, -1))).z());
    }
    EXPECT_NEAR(lowest, 0, 1e-6) << "seed " << seed;
    const Camera moved = camera.of_placement(seed);
    EXPECT_TRUE(ImageBounds(std::move(parts)).project(moved, p.pose[t])->inside(moved)) << "seed " << seed;
  }
}

TEST(Randomisation, TheCameraMovesAsFarAsAllowedAndKeepsItsRoll) {
  for (const Vec3& eye : {Vec3(0.55, 0, 0.55), Vec3(0, 0, 0.7)}) {
    proto::CameraConfig config;
    *config.mutable_eye() = to_proto(eye);
    config.set_eye_jitter(0.04);
    config.set_aim_jitter(0.02);
    const Camera camera = *Camera::create(config);
    double farthest = 0;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
      const Camera moved = camera.of_placement(seed);
      EXPECT_EQ(moved.eye(), camera.of_placement(seed).eye());
      const Vec3 step = moved.eye() - eye;
      farthest = std::max(farthest, step.cwiseAbs().maxCoeff());
      EXPECT_LE(step.cwiseAbs().maxCoeff(), 0.04);
      const Vec3 forward = moved.pose().rotation.col(2);
      const Vec3 aim = moved.eye() - moved.eye().z() / forward.z() * forward;
      EXPECT_LE(aim.cwiseAbs().maxCoeff(), 0.02 + 1e-12);
      EXPECT_GT(moved.pose().rotation.col(1).dot(camera.pose().rotation.col(1)), 0.98) << "no roll";
      EXPECT_NEAR(moved.pose().rotation.determinant(), 1, 1e-12);
    }
    EXPECT_GT(farthest, 0.039);
  }
  const Camera still = *Camera::create(proto::CameraConfig());
  EXPECT_EQ(still.of_placement(7).pose().rotation, still.pose().rotation);
}

TEST(Randomisation, TrialsOfManySizesArePureAndTakeNoOrder) {
  const Scenes scenes = make(kObjects, 0.3, 0.03, 0.02);
  const auto forward = scenes.sim->make_workspace(), backward = scenes.sim->make_workspace();
  constexpr std::uint64_t kTrials = 200;
  std::vector<std::uint64_t> first(kTrials);
  const auto digest = [&](std::uint64_t i, Workspace& workspace) {
    const Placements p = *scenes.sim->shuffle(i);
    const int target = target_of(p);
    return testing::digest_of(
        scenes.sim->get_quality(p, target, tool_for(*scenes.sim, p, target, i), workspace));
  };
  for (std::uint64_t i = 0; i < kTrials; ++i) first[i] = digest(i, *forward);
  for (std::uint64_t i = kTrials; i-- > 0;) EXPECT_EQ(digest(i, *backward), first[i]) << "trial " << i;
}

// The factor of each object's friction: of the seed alone, over the whole range, the same for every link.
TEST(Randomisation, FrictionFillsItsRangeAndComesFromTheSeed) {
  proto::Config config;
  config.mutable_scene()->set_friction_jitter(0.4);
  const auto jittered = testing::make_simulator({"cylinder", "cube"}, "meka_h2", config);
  const auto plain = testing::make_simulator({"cylinder", "cube"});
  const HandModel hand = *HandModel::create(plain->hand());
  const std::vector<proto::ObjectBundle> objects = {plain->object(0), plain->object(1)};
  const Friction with(jittered->experiment().scene(), objects, hand);
  const Friction without(plain->experiment().scene(), objects, hand);
  double least = 2, most = 0, sum = 0;
  constexpr int kSeeds = 500;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    double factor[2];
    for (int o = 0; o < 2; ++o) {
      factor[o] = with.mu(o, 1, seed) / without.mu(o, 1, seed);
      EXPECT_EQ(with.mu(o, 1, seed), with.mu(o, 1, seed));
      EXPECT_NEAR(with.mu(o, 0, seed) / without.mu(o, 0, seed), factor[o], 1e-12);
      EXPECT_EQ(without.mu(o, 1, seed), without.mu(o, 1, seed + 1));
      least = std::min(least, factor[o]), most = std::max(most, factor[o]), sum += factor[o];
      ASSERT_TRUE(factor[o] >= 0.6 && factor[o] < 1.4);
    }
    EXPECT_NE(factor[0], factor[1]) << "each object has its own";
  }
  EXPECT_LT(least, 0.62);
  EXPECT_GT(most, 1.38);
  EXPECT_NEAR(sum / (2 * kSeeds), 1, 0.03);
}

// The hand moves and touches as ever; the contacts rub as the seed says, and epsilon with them.
TEST(Randomisation, FrictionChangesTheGraspsQualityAndNothingElse) {
  proto::Config config;
  config.mutable_scene()->set_friction_jitter(0.4);
  const auto jittered = testing::make_simulator({"cube"}, "meka_h2", config);
  const auto plain = testing::make_simulator({"cube"});
  const auto one = jittered->make_workspace(), two = plain->make_workspace();
  int better = 0, worse = 0;
  for (std::uint64_t i = 0; i < 1500; ++i) {
    const testing::Trial trial = testing::random_trial(*plain, i);
    GraspReport a, b;
    jittered->get_quality(trial.placements, 0, trial.tool, *one, &a);
    plain->get_quality(trial.placements, 0, trial.tool, *two, &b);
    ASSERT_EQ(a.joints, b.joints) << "trial " << i;
    ASSERT_EQ(a.contacts.size(), b.contacts.size()) << "trial " << i;
    if (b.contacts.empty()) continue;
    const double factor = a.contacts[0].mu / b.contacts[0].mu;
    for (std::size_t c = 0; c < a.contacts.size(); ++c)
      ASSERT_NEAR(a.contacts[c].mu / b.contacts[c].mu, factor, 1e-12);
    // Wider cones hold narrower ones.
    const double gain = a.measurement.quality - b.measurement.quality;
    ASSERT_GE(factor > 1 ? gain : -gain, -1e-9) << "trial " << i;
    better += gain > 1e-6 ? 1 : 0, worse += gain < -1e-6 ? 1 : 0;
  }
  EXPECT_GT(better, 20);
  EXPECT_GT(worse, 20);
}

// The trial is the same to the bit; what is lifted weighs what the seed says.
TEST(Randomisation, MassIsFeltByTheLiftTestAlone) {
  proto::Config config;
  config.mutable_scene()->set_mass_jitter(0.9);
  const auto jittered = testing::make_simulator({"cube"}, "meka_h2", config);
  const auto plain = testing::make_simulator({"cube"});
  const auto one = jittered->make_workspace(), two = plain->make_workspace();
  int lifts = 0, different = 0;
  for (std::uint64_t i = 0; lifts < 4; ++i) {
    ASSERT_LT(i, 200u) << "no grasp closes";
    const testing::Trial trial = testing::random_trial(*plain, i);
    GraspReport a, b;
    jittered->get_quality(trial.placements, 0, trial.tool, *one, &a);
    plain->get_quality(trial.placements, 0, trial.tool, *two, &b);
    ASSERT_EQ(testing::digest_of(a.measurement), testing::digest_of(b.measurement)) << "trial " << i;
    if (b.measurement.quality <= 0) continue;
    ++lifts;
    const auto heavy = lift_test(*jittered, trial.placements, 0, a),
               again = lift_test(*jittered, trial.placements, 0, a);
    const auto usual = lift_test(*plain, trial.placements, 0, b);
    ASSERT_TRUE(heavy && again && usual);
    EXPECT_EQ(testing::digest_of(*heavy), testing::digest_of(*again)) << "of the seed alone";
    different += testing::digest_of(*heavy) != testing::digest_of(*usual) ? 1 : 0;
  }
  EXPECT_EQ(different, lifts) << "another mass moves otherwise";
}

TEST(Randomisation, MassAndInertiaFollowSizeAndDensity) {
  const proto::ObjectBundle one = make({"cube"}, 0).resolved.objects[0];
  const proto::ObjectBundle two = scaled(one, 2, 0.5);
  EXPECT_NEAR(two.mass(), 4 * one.mass(), 1e-12);
  EXPECT_NEAR(two.inertia(0), 16 * one.inertia(0), 1e-12);
  EXPECT_NEAR(two.resting(0).height(), 2 * one.resting(0).height(), 1e-12);
  EXPECT_NEAR(two.torque_scale(), 2 * one.torque_scale(), 1e-12);
  EXPECT_EQ(scaled(one, 1).SerializeAsString(), one.SerializeAsString());
}

}  // namespace
}  // namespace evograsp::sim

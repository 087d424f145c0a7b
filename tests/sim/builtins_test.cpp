// Whatever ships with the program can be simulated: every object with every hand.
#include <gtest/gtest.h>

#include "assets/assets.h"
#include "sim/simulator.h"

namespace evograsp::sim {
namespace {

TEST(BuiltIns, EveryObjectCanBeLookedAtAndGraspedWithEveryHand) {
  for (const std::string& hand : assets::builtin_hands()) {
    for (const std::string& object : assets::builtin_objects()) {
      proto::Config config;
      config.mutable_scene()->add_object(object);
      config.mutable_grasp()->set_hand(hand);
      const auto experiment = assets::resolve_experiment(config, ".");
      ASSERT_TRUE(experiment) << object << ": " << experiment.error().message;
      const auto sim = Simulator::create(experiment->experiment, experiment->objects, experiment->hand);
      ASSERT_TRUE(sim) << object << ": " << sim.error().message;
      const auto placements = (*sim)->shuffle(1);
      ASSERT_TRUE(placements) << object << ": " << placements.error().message;
      const auto info = (*sim)->get_info(*placements, 0, 0, true);
      ASSERT_TRUE(info) << object << ": " << info.error().message;
      EXPECT_GT(info->point.z(), 0) << object << " is clicked below the table";
      const std::vector<float> straight_down(kOutputs, 0.0F);
      const auto workspace = (*sim)->make_workspace();
      const Measurement m =
          (*sim)->get_quality(*placements, 0, (*sim)->decode(straight_down, *info, true), *workspace);
      EXPECT_NE(m.outcome, proto::NOT_A_NUMBER) << object << " with " << hand;
    }
  }
}

// A core of points in one plane: the rays must still meet what the fingers touch.
TEST(BuiltIns, AFlatHullIsSeenWhereItsRoundingIs) {
  proto::ObjectBundle object;
  object.set_name("sheet");
  object.set_material("plastic");
  object.set_torque_scale(0.03);
  object.set_footprint_radius(0.03);
  object.set_mass(0.1);
  object.add_resting()->set_height(0.02);
  proto::ConvexPart* part = object.add_part();
  part->set_rounding(0.0005);
  for (const double v : {-0.02, -0.02, 0.0, 0.02, -0.02, 0.0, 0.02, 0.02, 0.0, -0.02, 0.02, 0.0})
    part->mutable_hull()->add_xyz(v);
  proto::Config config;
  config.mutable_scene()->add_object("cube");
  auto experiment = assets::resolve_experiment(config, ".");
  ASSERT_TRUE(experiment);
  const auto sim = Simulator::create(experiment->experiment, {object}, experiment->hand);
  ASSERT_TRUE(sim) << sim.error().message;
  const auto placements = (*sim)->shuffle(1);
  ASSERT_TRUE(placements);
  const auto info = (*sim)->get_info(*placements, 0, 0, true);
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_NEAR(info->point.z(), 0.0205, 1e-4);
}

}  // namespace
}  // namespace evograsp::sim

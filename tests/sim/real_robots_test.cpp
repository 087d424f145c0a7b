// Robots and scans that others made, from file to trial.
#include <gtest/gtest.h>

#include "tests/data_folder.h"
#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

TEST(RealRobots, GraspBuiltInObjectsAndScans) {
  const std::filesystem::path data = evograsp::testing::data_folder();
  if (data.empty()) return;
  for (const char* file : {"meka_dreamer/h2_hand_right_lowres.urdf", "meka_dreamer/dreamer_lowres.urdf",
                           "meka_dreamer/meka_description/robots/uta.urdf",
                           "allegro_right/allegro_hand_description/allegro_hand_description_right.urdf"}) {
    const auto sim = testing::make_simulator(
        {"cube", "mug", (data / "meshes/tennis_ball_ycb/tennis_ball_ycb.stl").string()},
        (data / "robots" / file).string());
    const auto workspace = sim->make_workspace();
    int touched = 0, closed = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
      const testing::Trial trial = testing::random_trial(*sim, i);
      const Measurement m = sim->get_quality(trial.placements, trial.target, trial.tool, *workspace);
      ASSERT_NE(m.outcome, proto::NOT_A_NUMBER) << file << " trial " << i;
      touched += m.contacts > 0 ? 1 : 0;
      closed += m.quality > 0 ? 1 : 0;
    }
    std::printf("%s: of 400 trials %d touch the target, %d close\n", file, touched, closed);
    EXPECT_GT(touched, 15) << file;
  }
}

}  // namespace
}  // namespace evograsp::sim

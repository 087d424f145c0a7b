// docs/REACH.md says that one pose, turned with the object, closes on each of the thesis's objects wherever
// it stands. Its poses, replayed.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

using nlohmann::json;

// The same placements as bench/reach.cpp counts on.
Placements test_placement(const Simulator& sim, std::uint64_t index) {
  for (std::uint64_t attempt = 0; attempt <= 100; ++attempt) {
    if (auto placed = sim.shuffle(hash_key(1, Purpose::kTest, attempt, index))) return *placed;
  }
  std::abort();
}

// `pose` is relative to the centre of mass, in the frame that stands upright there and turns with the
// object's yaw.
Pose tool_of(const Simulator& sim, const Placements& p, const json& pose) {
  const auto& resting = sim.object(0).resting(p.resting[0]);
  const Mat3 turn = p.pose[0].rotation * from_proto(resting.orientation()).transpose();
  const auto number = [&](const char* key, int k) {
    return pose[key][static_cast<std::size_t>(k)].get<double>();
  };
  proto::Quat q;
  q.set_w(number("quaternion_wxyz", 0)), q.set_x(number("quaternion_wxyz", 1));
  q.set_y(number("quaternion_wxyz", 2)), q.set_z(number("quaternion_wxyz", 3));
  const Vec3 offset(number("offset", 0), number("offset", 1), number("offset", 2));
  const Vec3 centre = p.pose[0] * from_proto(sim.object(0).centre_of_mass());
  return {turn * from_proto(q), centre + turn * offset};
}

TEST(Reach, TheRecordedPosesCloseOnTheThesissObjects) {
  std::ifstream in(EVOGRASP_SOURCE_DIR "/docs/results/reach.json");
  const json entries = json::parse(in, nullptr, false);
  ASSERT_TRUE(entries.is_array());
  int replayed = 0;
  for (const char* object :
       {"cylinder", "cuboid", "cube_6cm", "cube_5cm", "sphere_4cm", "sphere_3cm", "mug", "plated_mug"}) {
    for (const json& entry : entries) {
      if (entry["object"] != object) continue;
      ++replayed;
      const auto sim = testing::make_simulator({object});
      const auto workspace = sim->make_workspace();
      int closed = 0;
      double quality = 0;
      for (std::uint64_t i = 0; i < 100; ++i) {
        const Placements p = test_placement(*sim, i);
        const Measurement m = sim->get_quality(p, 0, tool_of(*sim, p, entry["heading"]["pose"]), *workspace);
        closed += m.outcome == proto::GRASPED && m.quality > 0 ? 1 : 0;
        quality += m.quality / 100;
      }
      EXPECT_GE(closed, 95) << object;
      EXPECT_NEAR(quality, entry["heading"]["mean_quality"].get<double>(), 1e-3) << object << ": as recorded";
    }
  }
  EXPECT_EQ(replayed, 8);
}

}  // namespace
}  // namespace evograsp::sim

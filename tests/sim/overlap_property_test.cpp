// Objects on one table do not touch: by the exact distance of their parts, whatever shape and size they have.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "sim/world.h"
#include "tests/sim/attempt_parts.h"

namespace evograsp::sim {
namespace {

using testing::AttemptParts;

// The smallest distance between parts of different objects; 1 when a bounding box says that they are farther
// apart.
double least_between(const PosedWorld& posed) {
  double least = 1;
  for (const Obstacle& a : posed.obstacle) {
    for (const Obstacle& b : posed.obstacle) {
      if (a.object >= b.object || a.object == kTableObject) continue;
      if (a.box.overlaps(b.box, 0.02)) least = std::min(least, distance(*a.shape, a.pose, b).distance);
    }
  }
  return least;
}

void expect_apart(const std::vector<std::string>& objects, int together, double size_jitter, int seeds) {
  proto::Config config;
  config.mutable_scene()->set_objects_in_scene(static_cast<std::uint32_t>(together));
  config.mutable_scene()->set_size_jitter(size_jitter);
  config.mutable_scene()->set_placement_tries(100000);
  const auto sim = testing::make_simulator(objects, "meka_h2", config);
  const World world = AttemptParts::make_world(*sim, sim->object_count());
  PosedWorld posed;
  double least = 1;
  for (int seed = 0; seed < seeds; ++seed) {
    const auto placed = sim->shuffle(static_cast<std::uint64_t>(seed));
    ASSERT_TRUE(placed) << placed.error().message;
    world.place(*placed, posed);
    ASSERT_GT(posed.obstacle.size(), static_cast<std::size_t>(together)) << "an object without parts";
    least = std::min(least, least_between(posed));
    ASSERT_GT(least, 0) << "seed " << seed << ": objects overlap";
  }
  EXPECT_LT(least, 0.03) << "no two ever came near: nothing was tried";
  std::printf("%d of %zu objects, sizes +-%.0f %%: least distance %.2f mm\n", together, objects.size(),
              100 * size_jitter, 1e3 * least);
}

TEST(Overlap, BuiltInObjectsOfAnySizeStandApart) {
  expect_apart(assets::builtin_objects(), 3, 0.3, 1500);
}

TEST(Overlap, MeshesAmongThemStandApart) {
  expect_apart({"bottle", "cup", "mug", "cube"}, 3, 0.2, 500);
}

}  // namespace
}  // namespace evograsp::sim

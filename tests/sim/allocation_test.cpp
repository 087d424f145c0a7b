// A warm trial takes no memory: the hottest loop of the product must not wait for an allocator.
#include <gtest/gtest.h>

#include "tests/count_allocations.h"
#include "tests/sim/contact_sets.h"
#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

TEST(Allocation, AWarmTrialTakesNone) {
  const auto sim = testing::make_simulator({"cylinder", "cube", "sphere", "mug"});
  const auto workspace = sim->make_workspace();
  std::vector<testing::Trial> trials;
  for (std::uint64_t i = 0; i < 500; ++i) trials.push_back(testing::random_trial(*sim, i));
  const auto run = [&] {
    double sum = 0;
    for (const testing::Trial& t : trials)
      sum += sim->get_quality(t.placements, t.target, t.tool, *workspace).quality;
    return sum;
  };
  const double first = run();
  const std::uint64_t before = evograsp::testing::allocations();
  const double second = run();
  EXPECT_EQ(evograsp::testing::allocations() - before, 0u) << "in " << trials.size() << " trials";
  EXPECT_EQ(first, second);
  EXPECT_GT(before, 0u) << "the counter counts";
}

TEST(Allocation, AWarmEpsilonTakesNone) {
  std::vector<std::vector<Wrench>> sets;
  for (int i = 0; i < 400; ++i)
    sets.push_back(testing::draw_wrenches(testing::kKinds[i % 4], 3 + i / 4 % 18, i));
  Epsilon epsilon;
  const auto run = [&] {
    double sum = 0;
    for (const auto& set : sets) sum += epsilon(set);
    return sum;
  };
  const double first = run();
  const std::uint64_t before = evograsp::testing::allocations();
  const double second = run();
  EXPECT_EQ(evograsp::testing::allocations() - before, 0u) << "in " << sets.size() << " sets";
  EXPECT_EQ(first, second);
  EXPECT_GT(first, 10) << "closed grasps among them";
}

}  // namespace
}  // namespace evograsp::sim

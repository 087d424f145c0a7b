// A warm trial takes no memory: the hottest loop of the product must not wait for an allocator.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/sim/trials.h"

namespace {
std::atomic<long> allocations{0};
}

// NOLINTBEGIN: replacing the global operators is how allocations are counted.
void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete[](void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  std::free(p);
}
// NOLINTEND

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
  const long before = allocations;
  const double second = run();
  EXPECT_EQ(allocations - before, 0) << "in " << trials.size() << " trials";
  EXPECT_EQ(first, second);
  EXPECT_GT(before, 0) << "the counter counts";
}

}  // namespace
}  // namespace evograsp::sim

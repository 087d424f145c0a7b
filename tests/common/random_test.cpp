#include "common/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace evograsp {
namespace {

TEST(Random, SameKeySameStream) {
  Random a(5, Purpose::kClick, 3, 9);
  Random b(5, Purpose::kClick, 3, 9);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(a.next(), b.next());
}

// Consecutive seeds, generations and indices must not give shifted copies of one stream.
TEST(Random, NeighbouringKeysShareNoNumber) {
  std::set<std::uint64_t> seen;
  std::size_t drawn = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed)
    for (std::uint64_t generation = 0; generation < 8; ++generation)
      for (std::uint64_t index = 0; index < 8; ++index) {
        Random stream(seed, Purpose::kTrialSeeds, generation, index);
        for (int i = 0; i < 64; ++i, ++drawn) seen.insert(stream.next());
      }
  EXPECT_EQ(seen.size(), drawn);
}

TEST(Random, UniformHasTheRightMomentsAndStaysInRange) {
  Random random(7, Purpose::kTestHarness);
  double sum = 0, squares = 0;
  constexpr int kDraws = 1000000;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
  }
  EXPECT_NEAR(sum / kDraws, 0.5, 0.002);
  EXPECT_NEAR(squares / kDraws, 1.0 / 3, 0.002);
}

// First outputs of keys that differ in one bit: about half of all bits differ.
TEST(Random, OneBitOfTheKeyFlipsHalfTheOutput) {
  double flipped = 0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    for (int bit = 0; bit < 64; ++bit, ++count) {
      Random a(seed, Purpose::kTestHarness);
      Random b(seed ^ (1ULL << bit), Purpose::kTestHarness);
      flipped += __builtin_popcountll(a.next() ^ b.next());
    }
  EXPECT_NEAR(flipped / count, 32.0, 0.5);
}

TEST(Random, BelowCoversItsRangeEvenly) {
  Random random(8, Purpose::kTestHarness);
  std::vector<int> histogram(7);
  for (int i = 0; i < 70000; ++i) ++histogram[random.below(7)];
  for (const int n : histogram) EXPECT_NEAR(n, 10000, 500);
}

}  // namespace
}  // namespace evograsp

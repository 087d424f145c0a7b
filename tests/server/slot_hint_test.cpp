#include "server/slot_hint.h"

#include <gtest/gtest.h>

namespace evograsp::server {
namespace {

// Generations of `work` slot-seconds, `between` seconds apart.
SlotHint after(double work, double between, double smallest, std::uint64_t trials, int generations = 5) {
  SlotHint hint;
  double now = 0;
  for (int i = 0; i < generations; ++i) {
    hint.begin(now, trials);
    hint.finish(now += 1, work, smallest);
    now += between;
  }
  hint.begin(now, trials);
  return hint;
}

TEST(SlotHint, SaysNothingBeforeItHasSeenAGenerationAndAPause) {
  SlotHint hint;
  EXPECT_EQ(hint.slots(), 0U);
  hint.begin(0, 100);
  EXPECT_EQ(hint.slots(), 0U);
  hint.finish(1, 10, 0.001);
  EXPECT_EQ(hint.slots(), 0U);
  hint.begin(1.1, 100);
  EXPECT_GT(hint.slots(), 0U);
}

// 60 slot-seconds, 50 ms of breeding, tasks of 100 ms: n = 60 / 4 / 0.15 = 100, and with 100 slots a
// generation takes 0.15 + 0.6 s, of which 0.6 are busy: four fifths.
TEST(SlotHint, KeepsThatManyBusyForFourFifthsOfTheTime) {
  EXPECT_NEAR(static_cast<double>(after(60, 0.05, 0.1, 1000000).slots()), 100, 1);
}

TEST(SlotHint, NeverMoreThanTrialsNorLessThanOne) {
  EXPECT_EQ(after(60, 0.05, 0.1, 40).slots(), 40U);
  EXPECT_EQ(after(0.001, 10, 0.1, 1000).slots(), 1U);
  EXPECT_EQ(after(60, 0, 0, 1000).slots(), 1000U) << "no pause at all";
}

TEST(SlotHint, FollowsWorkThatGrows) {
  SlotHint hint = after(10, 0.1, 0, 1000000);
  const auto before = hint.slots();
  double now = 100;
  for (int i = 0; i < 30; ++i) {
    hint.finish(now, 40, 0);
    hint.begin(now += 0.1, 1000000);
    now += 1;
  }
  EXPECT_NEAR(static_cast<double>(hint.slots()), 4.0 * static_cast<double>(before), 2);
}

}  // namespace
}  // namespace evograsp::server

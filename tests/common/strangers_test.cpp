#include "common/strangers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace evograsp {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Optional;

class StrangersTest : public ::testing::Test {
 protected:
  Strangers make(Strangers::Limits limits) {
    return Strangers(limits, [this] { return now_; });
  }
  double now_ = 1000;
};

TEST_F(StrangersTest, TheFirstOffenceOfEachAddressIsSaidAndTheRestSummedUp) {
  Strangers strangers = make({});
  EXPECT_THAT(strangers.note(Offence::kKey, "10.0.0.7", "key A"), Optional(std::string("10.0.0.7: key A")));
  for (int i = 0; i < 312; ++i) EXPECT_EQ(strangers.note(Offence::kKey, "10.0.0.7", "key A"), std::nullopt);
  EXPECT_THAT(strangers.note(Offence::kKey, "10.0.0.8", "key B"), Optional(HasSubstr("10.0.0.8")))
      << "one noisy address hides another";
  EXPECT_THAT(strangers.note(Offence::kHello, "10.0.0.7", "an old build"),
              Optional(HasSubstr("an old build")))
      << "a scanner hides a worker of the same address";
  now_ += 59;
  EXPECT_THAT(strangers.sums(), IsEmpty());
  now_ += 2;
  EXPECT_THAT(strangers.sums(), ElementsAre("10.0.0.7: key A, and 311 more"));
  EXPECT_THAT(strangers.sums(), IsEmpty()) << "said once";
  EXPECT_EQ(strangers.counts()[static_cast<std::size_t>(Offence::kKey)], 314u);
  EXPECT_EQ(strangers.counts()[static_cast<std::size_t>(Offence::kHello)], 1u);
}

// A probe that knocks every ten seconds for a day.
TEST_F(StrangersTest, WhoGoesOnIsSaidEverMoreRarelyUntilItHasBeenQuiet) {
  Strangers strangers = make({});
  int lines = 0;
  const auto knock = [&] {
    lines += strangers.note(Offence::kHandshake, "10.0.0.7", "hung up") ? 1 : 0;
    lines += static_cast<int>(strangers.sums().size());
  };
  for (int i = 0; i < 8640; ++i, now_ += 10) knock();
  EXPECT_GT(lines, 24);
  EXPECT_LT(lines, 40) << "about one an hour";
  now_ += 4 * 3600;
  lines = 0;
  knock();
  now_ += 61;
  knock();
  EXPECT_EQ(lines, 2) << "after hours of quiet it is news again";
}

TEST_F(StrangersTest, AFloodFromManyAddressesIsBoundedInMemoryAndLinesAndEveryOneCounts) {
  Strangers::Limits limits;
  limits.addresses = 100;
  limits.burst = 10;
  Strangers strangers = make(limits);
  std::uint64_t said = 0;
  for (int i = 0; i < 100000; ++i)
    said += strangers.note(Offence::kHandshake, "10." + std::to_string(i), "scans") ? 1 : 0;
  EXPECT_EQ(said, 10u);
  EXPECT_EQ(strangers.addresses(), 100u);
  EXPECT_EQ(strangers.counts()[0], 100000u);
  // Everything that was not said comes in a sum, sooner or later, a line a second.
  std::uint64_t summed = 0, longest = 0;
  for (int second = 0; second < 200; ++second, now_ += 1) {
    const auto lines = strangers.sums();
    longest = std::max(longest, static_cast<std::uint64_t>(lines.size()));
    for (const std::string& line : lines) {
      const bool sum = line.find(" refusals ") != std::string::npos;
      summed += sum ? std::stoull(line.substr(line.find(": ") + 2)) : 1;
    }
  }
  EXPECT_EQ(said + summed, 100000u);
  EXPECT_LE(longest, 3u);
}

TEST_F(StrangersTest, NobodyKnowsAnEmptyAddress) {
  Strangers strangers = make({});
  EXPECT_THAT(strangers.note(Offence::kHandshake, "", "scans"), Optional(HasSubstr("somebody")));
  EXPECT_EQ(strangers.note(Offence::kHandshake, "", "scans"), std::nullopt);
}

}  // namespace
}  // namespace evograsp

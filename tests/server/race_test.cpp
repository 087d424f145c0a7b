// Racing: who goes on to optional trials.
#include "server/race.h"

#include <gtest/gtest.h>

#include <limits>

namespace evograsp::server {
namespace {

proto::RaceConfig config(double keep, double deviations) {
  proto::RaceConfig c;
  c.set_keep(keep);
  c.set_deviations(deviations);
  return c;
}

using Scores = std::vector<std::vector<double>>;
using Racing = std::vector<std::uint32_t>;

TEST(Race, KeepsTheBestShareInOrderOfTheirMeans) {
  const Scores scores = {{0.1, 0.9}, {0.9, 0.2}, {0.5, 0.1}, {0.8, 0.4}};  // means 0.5, 0.55, 0.3, 0.6
  EXPECT_EQ(racers(config(0.75, 100), scores, {0, 1, 2, 3}), (Racing{3, 1, 0}));
  EXPECT_EQ(racers(config(0.5, 100), scores, {0, 1, 2}), (Racing{1, 0}));  // ceil(1.5)
  EXPECT_EQ(racers(config(0.01, 100), scores, {0, 1, 2, 3}), (Racing{3}));
}

TEST(Race, DropsThoseBeatenBeyondDoubtThoughTheShareHasRoom) {
  // Against 0: genome 1 is worse by 0.1 in every trial (no doubt); genome 2 by 0.1 in the mean, now better,
  // now worse: differences 0.5, -0.3, 0.5, -0.3 have a standard error of 0.23.
  const Scores scores = {{0.9, 0.5, 0.9, 0.5}, {0.8, 0.4, 0.8, 0.4}, {0.4, 0.8, 0.4, 0.8}};
  EXPECT_EQ(racers(config(1, 2), scores, {0, 1, 2}), (Racing{0, 2}));
  EXPECT_EQ(racers(config(1, 0.4), scores, {0, 1, 2}), (Racing{0}));
}

TEST(Race, TiesGoToTheLowerIndexWhateverTheOrderTheyCameIn) {
  const Scores scores = {{0.5, 0.5}, {0.5, 0.5}, {0.5, 0.5}};
  EXPECT_EQ(racers(config(0.6, 2), scores, {2, 1, 0}), (Racing{0, 1}));
}

TEST(Race, WhatIsNotANumberNeverLeads) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Scores scores = {{nan, 1}, {0.1, 0.2}};
  EXPECT_EQ(racers(config(1, 2), scores, {0, 1}), (Racing{1}));
  EXPECT_TRUE(racers(config(1, 2), scores, {}).empty());
}

}  // namespace
}  // namespace evograsp::server

// What the run loop hears of the workers' results.
#include "server/gather.h"

#include "tests/server/store_fixture.h"

namespace evograsp::server {
namespace {

class GatherTest : public ::testing::Test {
 protected:
  GatherTest()
      : store_(std::move(*Store::create(folder_.path(), new_run()))),
        scorer_(*score::Scorer::create(proto::FitnessConfig())),
        gather_(scorer_, *store_) {
    gather_.begin(Gather::Kind::kGeneration, 0, {{1, 0}, {2, 0}}, std::vector<proto::TrialKey>(1));
    gather_.pending();
  }
  void evaluated(std::uint32_t network, proto::Outcome outcome) {
    std::vector<proto::Measurement> measurements(1);
    measurements[0].set_outcome(outcome);
    gather_.evaluated(network, std::move(measurements));
  }

  RunFolder folder_;
  std::unique_ptr<Store> store_;
  score::Scorer scorer_;
  Gather gather_;
};

TEST_F(GatherTest, AGenerationOfWhichNoTrialCanBeHeldIsAnError) {
  gather_.notice("the table is too small");
  evaluated(0, proto::NO_TRIAL);
  evaluated(1, proto::NO_TRIAL);
  EXPECT_TRUE(gather_.wait(0));
  ASSERT_TRUE(gather_.error());
  EXPECT_NE(gather_.error()->message.find("the table is too small"), std::string::npos);
}

TEST_F(GatherTest, OneThatCouldBeHeldIsEnough) {
  evaluated(0, proto::NO_TRIAL);
  evaluated(1, proto::MISSED);
  EXPECT_TRUE(gather_.wait(0));
  EXPECT_FALSE(gather_.error());
}

// A liar says that no trial can be held; what it said is done again.
TEST_F(GatherTest, WhatWasRetractedCountsForNothing) {
  evaluated(0, proto::NO_TRIAL);
  gather_.retracted({0});
  evaluated(0, proto::MISSED);
  evaluated(1, proto::NO_TRIAL);
  EXPECT_TRUE(gather_.wait(0));
  EXPECT_FALSE(gather_.error()) << gather_.error()->message;
}

}  // namespace
}  // namespace evograsp::server

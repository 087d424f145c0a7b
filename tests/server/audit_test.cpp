// The auditor's book and the scheduler's part in audits, by hand.
#include "server/audit.h"

#include <gtest/gtest.h>

#include "server/scheduler.h"

namespace evograsp::server {
namespace {

using State = Auditor::State;

TEST(Auditor, TwoThatAgreeCloseTheCase) {
  Auditor auditor;
  const auto number = auditor.open({3, 0, 5}, Party(1), "bits");
  const auto verdict = auditor.opinion(number, Party(2), "bits");
  EXPECT_EQ(verdict.state, State::kAgreed);
  EXPECT_EQ(verdict.piece.network, 3U);
  EXPECT_EQ(auditor.opinion(number, Party(4), "other").state, State::kStale);
}

TEST(Auditor, AThirdDecidesAgainstTheFirstOrTheSecond) {
  Auditor auditor;
  auto number = auditor.open({0, 0, 1}, Party(1), "lie");
  auto verdict = auditor.opinion(number, Party(2), "truth");
  EXPECT_EQ(verdict.state, State::kDisputed);
  EXPECT_EQ(verdict.heard, (std::vector<Party>{Party(1), Party(2)}));
  verdict = auditor.opinion(number, Party(3), "truth");
  EXPECT_EQ(verdict.state, State::kDecided);
  EXPECT_EQ(verdict.liars, std::vector<Party>{Party(1)});

  number = auditor.open({0, 0, 1}, Party(1), "truth");
  auditor.opinion(number, Party(2), "lie");
  EXPECT_EQ(auditor.opinion(number, Party(3), "truth").liars, std::vector<Party>{Party(2)});
}

TEST(Auditor, ThreeDifferentOpinionsNeedAFourth) {
  Auditor auditor;
  const auto number = auditor.open({0, 0, 1}, Party(1), "a");
  auditor.opinion(number, Party(2), "b");
  EXPECT_EQ(auditor.opinion(number, Party(3), "c").state, State::kDisputed);
  EXPECT_EQ(auditor.opinion(number, Party(4), "b").liars, (std::vector<Party>{Party(1), Party(3)}));
}

TEST(Auditor, DiscardingAPartyGivesItsPiecesAndClosesTheirCases) {
  Auditor auditor;
  auditor.did({0, 0, 5}, Party(1));
  auditor.did({1, 0, 5}, Party(2));
  auditor.did({2, 5, 5}, Party(1));
  const auto number = auditor.open({2, 5, 5}, Party(1), "x");
  const auto discarded = auditor.discard(Party(1));
  ASSERT_EQ(discarded.pieces.size(), 2U);
  EXPECT_EQ(discarded.pieces[1].network, 2U);
  EXPECT_EQ(discarded.cases, std::vector<std::uint32_t>{number});
  EXPECT_EQ(auditor.opinion(number, Party(3), "y").state, State::kStale);
  EXPECT_TRUE(auditor.discard(Party(1)).pieces.empty());
}

// Two workers of one machine share its faults and its owner.
TEST(Auditor, WhereTwoHostsAreHeardOneHostDoesNotAgreeWithItself) {
  const Party a1(1, 10), a2(2, 10), b1(3, 20), b2(4, 20), c(5, 30);
  Auditor auditor;
  const auto number = auditor.open({0, 0, 1}, a1, "lie");
  EXPECT_EQ(auditor.opinion(number, b1, "truth").state, State::kDisputed);
  EXPECT_EQ(auditor.opinion(number, a2, "lie").state, State::kDisputed) << "a machine confirmed itself";
  EXPECT_EQ(auditor.opinion(number, b2, "truth").state, State::kDisputed);
  const auto verdict = auditor.opinion(number, c, "truth");
  EXPECT_EQ(verdict.state, State::kDecided);
  EXPECT_EQ(verdict.liars, (std::vector<Party>{a1, a2}));
}

TEST(Auditor, AWorkerOfTheLiarsHostMayConvictIt) {
  const Party a1(1, 10), a2(2, 10), b1(3, 20);
  Auditor auditor;
  const auto number = auditor.open({0, 0, 1}, a1, "lie");
  auditor.opinion(number, b1, "truth");
  EXPECT_EQ(auditor.opinion(number, a2, "truth").liars, std::vector<Party>{a1});
}

TEST(Auditor, OnOneHostTwoWorkersAreEnough) {
  Auditor auditor;
  const auto number = auditor.open({0, 0, 1}, Party(1, 10), "bits");
  EXPECT_EQ(auditor.opinion(number, Party(2, 10), "bits").state, State::kAgreed);
}

// One network of one trial, done by worker 1; worker 2 of another identity.
class ScheduledAudit : public ::testing::Test {
 protected:
  ScheduledAudit() {
    SchedulerOptions options;
    options.speculate = false;
    scheduler_ = Scheduler(options);
    scheduler_.join(1, 1, Party(100));
    scheduler_.begin(1, 1);
    scheduler_.add(0, 1000);
  }
  // Worker 1's result arrives and is to be audited.
  void first_result() {
    const auto task = scheduler_.next(1, 0);
    ASSERT_TRUE(task);
    scheduler_.audit(7, {0, 0, 1}, {Party(100)});
    EXPECT_TRUE(scheduler_.result(1, task->task, 0.001).complete.empty()) << "an audit is outstanding";
  }
  Scheduler scheduler_{{}};
};

TEST_F(ScheduledAudit, GoesToAnotherPartyAndOnlyThenIsTheNetworkComplete) {
  scheduler_.join(2, 1, Party(200));
  scheduler_.join(3, 1, Party(100));  // the first one's other session
  first_result();
  EXPECT_FALSE(scheduler_.next(1, 0));
  EXPECT_FALSE(scheduler_.next(3, 0));
  const auto audit = scheduler_.next(2, 0);
  ASSERT_TRUE(audit);
  EXPECT_EQ(audit->audit, 7U);
  EXPECT_EQ(scheduler_.result(2, audit->task, 0.001).complete, std::vector<std::uint32_t>{0});
  EXPECT_TRUE(scheduler_.finished());
}

TEST_F(ScheduledAudit, OfALostAuditorGoesToTheNext) {
  scheduler_.join(2, 1, Party(200));
  first_result();
  ASSERT_TRUE(scheduler_.next(2, 0));
  scheduler_.leave(2, Departure::kDied);
  EXPECT_FALSE(scheduler_.next(1, 0));
  scheduler_.join(4, 1, Party(400));
  const auto audit = scheduler_.next(4, 0);
  ASSERT_TRUE(audit);
  EXPECT_EQ(audit->audit, 7U);
}

TEST_F(ScheduledAudit, IsSkippedWhenNobodyIsLeftForIt) {
  scheduler_.join(2, 1, Party(200));
  first_result();
  EXPECT_TRUE(scheduler_.skip_audits().audits.empty()) << "worker 2 can still do it";
  scheduler_.set_active(2, false);
  EXPECT_TRUE(scheduler_.skip_audits(true).audits.empty()) << "somebody may be back at once";
  const auto skipped = scheduler_.skip_audits();
  EXPECT_EQ(skipped.audits, std::vector<std::uint32_t>{7});
  EXPECT_EQ(skipped.complete, std::vector<std::uint32_t>{0});
  EXPECT_TRUE(scheduler_.finished());
}

TEST_F(ScheduledAudit, GoesToAnotherHostWhileOneIsHere) {
  scheduler_.join(2, 1, Party(200));  // of the first one's host
  scheduler_.join(3, 1, Party(300, 9));
  first_result();
  EXPECT_FALSE(scheduler_.next(2, 0)) << "a machine confirms itself though another is here";
  const auto audit = scheduler_.next(3, 0);
  ASSERT_TRUE(audit);
  EXPECT_EQ(audit->audit, 7U);
}

TEST_F(ScheduledAudit, GoesToAnotherWorkerOfTheHostWhenNoOtherIsHere) {
  scheduler_.join(2, 1, Party(200));
  scheduler_.join(3, 1, Party(300, 9));
  first_result();
  scheduler_.set_active(3, false);
  EXPECT_TRUE(scheduler_.skip_audits().audits.empty());
  EXPECT_TRUE(scheduler_.next(2, 0));
}

TEST_F(ScheduledAudit, WaitsForAnotherHostThatIsAwayForAMoment) {
  scheduler_.join(2, 1, Party(200));
  first_result();
  scheduler_.await_hosts({9});
  EXPECT_FALSE(scheduler_.next(2, 0)) << "a machine confirms itself while the other host connects anew";
  EXPECT_TRUE(scheduler_.skip_audits().audits.empty());
  scheduler_.await_hosts({});
  EXPECT_TRUE(scheduler_.next(2, 0));
}

// The same identity seen from another machine is no other opinion, and keeps nobody from giving one.
TEST_F(ScheduledAudit, AnIdentityThatMovedIsStillTheSame) {
  scheduler_.join(2, 1, Party(200));
  scheduler_.join(3, 1, Party(100, 9));
  first_result();
  EXPECT_FALSE(scheduler_.next(3, 0));
  EXPECT_TRUE(scheduler_.next(2, 0));
}

TEST_F(ScheduledAudit, TheThirdOpinionComesFromAThirdHostWhenOneIsHere) {
  scheduler_.join(2, 1, Party(200, 9));
  first_result();
  const auto audit = scheduler_.next(2, 0);
  scheduler_.audit(7, {0, 0, 1}, {Party(100), Party(200, 9)});
  scheduler_.result(2, audit->task, 0.001);
  scheduler_.join(3, 1, Party(300, 9));
  scheduler_.join(4, 1, Party(400));
  scheduler_.join(5, 1, Party(500, 11));
  EXPECT_FALSE(scheduler_.next(3, 0));
  EXPECT_FALSE(scheduler_.next(4, 0));
  scheduler_.set_active(5, false);
  EXPECT_TRUE(scheduler_.next(4, 0)) << "with nobody else, any of whom nothing has been heard";
}

TEST_F(ScheduledAudit, ADisputeIsNeverSkipped) {
  scheduler_.join(2, 1, Party(200));
  first_result();
  const auto audit = scheduler_.next(2, 0);
  scheduler_.audit(7, {0, 0, 1}, {Party(100), Party(200)});
  EXPECT_TRUE(scheduler_.result(2, audit->task, 0.001).complete.empty());
  const auto skipped = scheduler_.skip_audits();
  EXPECT_TRUE(skipped.audits.empty());
  EXPECT_TRUE(skipped.disputed);
  EXPECT_FALSE(scheduler_.finished());
  scheduler_.join(3, 1, Party(300));
  EXPECT_FALSE(scheduler_.skip_audits().disputed);
  EXPECT_TRUE(scheduler_.next(3, 0));
}

TEST_F(ScheduledAudit, WhatALiarDidIsDoneAgain) {
  const auto task = scheduler_.next(1, 0);
  EXPECT_EQ(scheduler_.result(1, task->task, 0.001).complete.size(), 1U);
  EXPECT_TRUE(scheduler_.finished());
  EXPECT_TRUE(scheduler_.redo({0, 0, 1}));
  EXPECT_FALSE(scheduler_.finished());
  scheduler_.leave(1, Departure::kLeft);
  scheduler_.join(2, 1, Party(200));
  const auto again = scheduler_.next(2, 0);
  ASSERT_TRUE(again);
  EXPECT_EQ(scheduler_.result(2, again->task, 0.001).complete, std::vector<std::uint32_t>{0});
  EXPECT_TRUE(scheduler_.finished());
}

}  // namespace
}  // namespace evograsp::server

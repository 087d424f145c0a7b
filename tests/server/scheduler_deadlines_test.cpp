// The scheduler and time: slots that hang, workers that hold what they do not start.
#include <gtest/gtest.h>

#include "server/scheduler.h"

namespace evograsp::server {
namespace {

SchedulerOptions one_second(bool speculate = false) {
  SchedulerOptions options;
  options.task_deadline = 1;
  options.credit = 1;
  options.speculate = speculate;
  return options;
}

void begin(Scheduler& scheduler, std::uint32_t networks, std::uint32_t trials) {
  scheduler.begin(networks, trials);
  for (std::uint32_t i = 0; i < networks; ++i) scheduler.add(i, 1 << 20);  // too large to share a task
}

void give_back(Scheduler& scheduler, WorkerId worker, const Assignment& what, double now) {
  scheduler.came_back(worker, what.task, what.attempt, now);
  if (scheduler.find(worker, what.task, what.attempt)) scheduler.result(worker, what.task, 1e-3);
}

TEST(SchedulerDeadlines, SayingItsStartAgainBuysNoTime) {
  Scheduler scheduler(one_second());
  scheduler.join(1, 1);
  begin(scheduler, 1, 1);
  const auto what = scheduler.next(1, 0);
  ASSERT_TRUE(what);
  for (double now = 0; now < 1; now += 0.25) {
    scheduler.started(1, what->task, what->attempt, now);
    EXPECT_TRUE(scheduler.expire(now).empty()) << now;
  }
  EXPECT_EQ(scheduler.expire(1.1).size(), 1U) << "the clock began anew with each Started";
}

TEST(SchedulerDeadlines, WhoStartsNothingIsIdleAfterADeadlineAndASecond) {
  Scheduler scheduler(one_second());
  scheduler.join(1, 1);
  begin(scheduler, 1, 1);
  EXPECT_TRUE(scheduler.idle(100).empty()) << "who holds nothing is not idle";
  ASSERT_TRUE(scheduler.next(1, 100));
  EXPECT_TRUE(scheduler.expire(103).empty()) << "what has not started does not hang";
  EXPECT_TRUE(scheduler.idle(101.9).empty());
  EXPECT_EQ(scheduler.idle(102.1), std::vector<WorkerId>{1});
  scheduler.leave(1, Departure::kLeft);
  EXPECT_EQ(scheduler.counts().strikes, 0U) << "what has not started is not to blame";
  scheduler.join(2, 1);
  EXPECT_TRUE(scheduler.next(2, 103));
}

// Deep queues take their time: whoever starts or brings something is at work.
TEST(SchedulerDeadlines, AWorkerThatGetsOnIsNotIdle) {
  SchedulerOptions options = one_second();
  options.credit = 5;
  Scheduler scheduler(options);
  scheduler.join(1, 1);
  begin(scheduler, 5, 1);
  std::vector<Assignment> held;
  while (const auto what = scheduler.next(1, 0)) held.push_back(*what);
  ASSERT_EQ(held.size(), 5U);
  for (std::size_t i = 0; i < held.size(); ++i) {
    const double now = 1.5 * static_cast<double>(i + 1);
    EXPECT_TRUE(scheduler.idle(now).empty()) << "after " << i << " tasks";
    if (i % 2 == 0) scheduler.started(1, held[i].task, held[i].attempt, now);
    give_back(scheduler, 1, held[i], now);
  }
  EXPECT_TRUE(scheduler.finished());
}

TEST(SchedulerDeadlines, ResultsOfWhatItDoesNotHoldAreNoWork) {
  Scheduler scheduler(one_second());
  scheduler.join(1, 1);
  begin(scheduler, 1, 1);
  const auto what = scheduler.next(1, 0);
  ASSERT_TRUE(what);
  for (double now = 0; now < 2; now += 0.1) {
    scheduler.came_back(1, what->task, what->attempt + 1, now);
    scheduler.came_back(1, 999, 0, now);
    scheduler.started(1, 999, 0, now);
  }
  EXPECT_EQ(scheduler.idle(2.1).size(), 1U) << "inventing results keeps a task for ever";
}

TEST(SchedulerDeadlines, ASlotThatHangsOnWhatSomebodyElseBroughtIsNoticed) {
  Scheduler scheduler(one_second(true));
  scheduler.join(1, 1);
  scheduler.join(2, 1);
  begin(scheduler, 2, 1);
  const auto hung = scheduler.next(1, 0), quick = scheduler.next(2, 0);
  ASSERT_TRUE(hung && quick);
  scheduler.started(1, hung->task, hung->attempt, 0);
  give_back(scheduler, 2, *quick, 0.1);
  const auto copy = scheduler.next(2, 0.5);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->task, hung->task);
  give_back(scheduler, 2, *copy, 0.6);
  EXPECT_TRUE(scheduler.finished());
  begin(scheduler, 1, 1);
  EXPECT_FALSE(scheduler.next(1, 0.7)) << "its one slot is taken";
  EXPECT_TRUE(scheduler.expire(0.9).empty());
  const auto expired = scheduler.expire(1.1);
  ASSERT_EQ(expired.size(), 1U) << "the copy's result made the hung slot forgotten";
  EXPECT_EQ(expired[0].worker, 1U);
  EXPECT_EQ(scheduler.slots(1), 0U);
  EXPECT_EQ(scheduler.counts().strikes, 0U) << "the network is innocent: somebody else did it";
  EXPECT_TRUE(scheduler.expire(9).empty()) << "once";
}

TEST(SchedulerDeadlines, AResultThatComesTooLateFreesItsSlot) {
  Scheduler scheduler(one_second(true));
  scheduler.join(1, 1);
  scheduler.join(2, 1);
  begin(scheduler, 2, 1);
  const auto slow = scheduler.next(1, 0), quick = scheduler.next(2, 0);
  ASSERT_TRUE(slow && quick);
  scheduler.started(1, slow->task, slow->attempt, 0);
  give_back(scheduler, 2, *quick, 0.1);
  const auto copy = scheduler.next(2, 0.5);
  ASSERT_TRUE(copy);
  give_back(scheduler, 2, *copy, 0.6);
  give_back(scheduler, 1, *slow, 0.8);  // a duplicate
  begin(scheduler, 1, 1);
  EXPECT_TRUE(scheduler.next(1, 0.9));
  EXPECT_TRUE(scheduler.expire(1.5).empty());
  EXPECT_EQ(scheduler.slots(1), 1U);
}

TEST(SchedulerDeadlines, WhatRunsOnWhenWorkIsDroppedStillHasItsSlot) {
  Scheduler scheduler(one_second());
  scheduler.join(1, 1);
  begin(scheduler, 1, 1);
  const auto what = scheduler.next(1, 0);
  ASSERT_TRUE(what);
  scheduler.started(1, what->task, what->attempt, 0);
  scheduler.abandon();
  EXPECT_EQ(scheduler.expire(1.1).size(), 1U);
}

// A suspect runs alone, so that nothing else can be blamed, and is never copied: only the clock can free it.
TEST(SchedulerDeadlines, ASuspectThatIsHeldButNotStartedGoesElsewhere) {
  Scheduler scheduler(one_second(true));
  scheduler.join(1, 1);
  begin(scheduler, 1, 1);
  const auto first = scheduler.next(1, 0);
  ASSERT_TRUE(first);
  scheduler.started(1, first->task, first->attempt, 0);
  scheduler.leave(1, Departure::kDied);
  scheduler.join(2, 1);
  scheduler.join(3, 1);
  const auto held = scheduler.next(2, 1);
  ASSERT_TRUE(held && held->suspect);
  EXPECT_FALSE(scheduler.next(3, 2)) << "suspects are not copied";
  EXPECT_EQ(scheduler.idle(3.5), std::vector<WorkerId>{2});
  scheduler.leave(2, Departure::kLeft);
  const auto again = scheduler.next(3, 4);
  ASSERT_TRUE(again && again->suspect);
  scheduler.started(3, again->task, again->attempt, 4);
  give_back(scheduler, 3, *again, 4.1);
  EXPECT_TRUE(scheduler.finished());
  EXPECT_EQ(scheduler.counts().strikes, 1U);
}

TEST(SchedulerDeadlines, AnAuditThatIsHeldButNotStartedIsNotWaitedForAgain) {
  Scheduler scheduler(one_second(true));
  scheduler.join(1, 1, Party(10));
  scheduler.join(2, 1, Party(20));
  begin(scheduler, 1, 1);
  const auto done = scheduler.next(1, 0);
  ASSERT_TRUE(done);
  scheduler.audit(7, {0, 0, 1}, {Party(10)});
  give_back(scheduler, 1, *done, 0.1);
  const auto opinion = scheduler.next(2, 0.2);
  ASSERT_TRUE(opinion && opinion->audit == 7);
  EXPECT_EQ(scheduler.auditors(), 2);
  EXPECT_EQ(scheduler.idle(2.5), std::vector<WorkerId>{2});
  scheduler.leave(2, Departure::kLeft);
  scheduler.join(3, 1, Party(20));  // the same party is back
  EXPECT_FALSE(scheduler.can_audit({Party(10)}));
  EXPECT_EQ(scheduler.auditors(), 1);
  EXPECT_FALSE(scheduler.next(3, 3)) << "it would hold up the audit again";
  EXPECT_EQ(scheduler.skip_audits().audits, std::vector<std::uint32_t>{7});
  EXPECT_TRUE(scheduler.finished());
  begin(scheduler, 1, 1);
  const auto ordinary = scheduler.next(3, 4);
  ASSERT_TRUE(ordinary) << "what can be copied it may still do";
  give_back(scheduler, 3, *ordinary, 4.1);
  EXPECT_TRUE(scheduler.can_audit({Party(10)})) << "it works again";
}

TEST(SchedulerDeadlines, ATimeInWhichTheMasterStoodStillMakesNobodyIdle) {
  Scheduler scheduler(one_second());
  scheduler.join(1, 1);
  begin(scheduler, 1, 1);
  ASSERT_TRUE(scheduler.next(1, 0));
  scheduler.excuse(60, 60.5);
  EXPECT_TRUE(scheduler.idle(60.5).empty());
  EXPECT_TRUE(scheduler.idle(61.9).empty());
  EXPECT_EQ(scheduler.idle(62.1).size(), 1U);
}

}  // namespace
}  // namespace evograsp::server

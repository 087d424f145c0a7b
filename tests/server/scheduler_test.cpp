// The scheduler with a clock of the test's own: sizes, credit, losses, stragglers, poison.
#include "server/scheduler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "common/random.h"

namespace evograsp::server {
namespace {

SchedulerOptions plain() {
  SchedulerOptions options;
  options.speculate = false;
  return options;
}

void begin(Scheduler& scheduler, std::uint32_t networks, std::uint32_t trials, std::size_t bytes = 1000) {
  scheduler.begin(networks, trials);
  for (std::uint32_t i = 0; i < networks; ++i) scheduler.add(i, bytes);
}

TEST(Scheduler, GivesEveryTrialOfEveryNetworkExactlyOnce) {
  Scheduler scheduler(plain());
  for (WorkerId w = 1; w <= 3; ++w) scheduler.join(w, 2);
  begin(scheduler, 37, 11);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> given;
  std::vector<std::uint32_t> complete;
  double now = 0;
  while (!scheduler.finished()) {
    for (WorkerId w = 1; w <= 3; ++w) {
      const auto what = scheduler.next(w, now);
      if (!what) continue;
      for (const std::uint32_t n : what->networks)
        for (std::uint32_t t = 0; t < what->trials; ++t) ++given[{n, what->first_trial + t}];
      now += 1e-3;
      const auto accepted = scheduler.result(w, what->task, 3e-4 * what->trials * what->networks.size());
      complete.insert(complete.end(), accepted.complete.begin(), accepted.complete.end());
    }
  }
  EXPECT_EQ(given.size(), 37U * 11U);
  for (const auto& [key, times] : given) EXPECT_EQ(times, 1);
  std::sort(complete.begin(), complete.end());
  for (std::uint32_t i = 0; i < 37; ++i) EXPECT_EQ(complete[i], i);
}

TEST(Scheduler, TasksShrinkTowardsTheEndAndKeepToTheTimeAsked) {
  SchedulerOptions options = plain();
  options.task_seconds = 0.01;
  Scheduler scheduler(options);
  scheduler.join(1, 2);
  begin(scheduler, 2000, 5);
  std::vector<std::size_t> sizes;
  while (const auto what = scheduler.next(1, 0)) {
    sizes.push_back(what->networks.size() * what->trials);
    scheduler.result(1, what->task, 1e-3 * static_cast<double>(sizes.back()));  // 1 ms a trial
  }
  // Once the cost is known: 10 trials of 1 ms.
  for (std::size_t i = 20; i < sizes.size(); ++i) EXPECT_LE(sizes[i], 10U) << i;
  EXPECT_LE(sizes.back(), 5U);
}

TEST(Scheduler, CutsOneLargeNetworkForManySlots) {
  Scheduler scheduler(plain());
  for (WorkerId w = 1; w <= 8; ++w) scheduler.join(w, 1);
  begin(scheduler, 1, 400);
  std::set<WorkerId> busy;
  for (WorkerId w = 1; w <= 8; ++w)
    if (scheduler.next(w, 0)) busy.insert(w);
  EXPECT_EQ(busy.size(), 8U) << "one network's trials must spread over all slots";
}

TEST(Scheduler, AWorkerGoesOnWithTheNetworkItBegan) {
  SchedulerOptions options = plain();
  options.task_seconds = 0.05;
  Scheduler scheduler(options);
  for (WorkerId w = 1; w <= 8; ++w) {
    scheduler.join(w, 1);
    scheduler.set_estimate(w, 0.05);
  }
  begin(scheduler, 64, 20);
  std::map<std::uint32_t, std::set<WorkerId>> seen;
  int tasks = 0;
  double now = 0;
  while (!scheduler.finished())
    for (WorkerId w = 1; w <= 8; ++w) {
      const auto what = scheduler.next(w, now);
      if (!what) continue;
      ++tasks;
      EXPECT_EQ(what->trials, 1U);
      seen[what->networks[0]].insert(w);
      scheduler.result(w, what->task, 0.05);
      now += 0.05;
    }
  std::size_t sent = 0;
  for (const auto& [network, workers] : seen) sent += workers.size();
  EXPECT_EQ(tasks, 64 * 20);
  EXPECT_LE(sent, 64U + 20U) << "a network goes to one worker; at the end of a generation some to more";
}

TEST(Scheduler, WhatADrainedWorkerBeganGoesToOthers) {
  Scheduler scheduler(plain());
  for (WorkerId w = 1; w <= 2; ++w) {
    scheduler.join(w, 1);
    scheduler.set_estimate(w, 0.05);
  }
  begin(scheduler, 1, 20);
  const auto first = scheduler.next(1, 0);
  ASSERT_TRUE(first);
  scheduler.set_active(1, false);
  scheduler.result(1, first->task, 0.05);
  std::uint32_t trials = first->trials;
  while (const auto what = scheduler.next(2, 0)) {
    EXPECT_EQ(what->first_trial, trials) << "from the front of what is left";
    trials += what->trials;
    scheduler.result(2, what->task, 0.05);
  }
  EXPECT_EQ(trials, 20U);
  EXPECT_TRUE(scheduler.finished());
}

TEST(Scheduler, ADeclaredCostSizesTheFirstTaskAndNonsenseDoesNot) {
  Scheduler scheduler(plain());
  for (WorkerId w = 1; w <= 3; ++w) scheduler.join(w, 1);
  scheduler.set_estimate(1, 0.001);
  scheduler.set_estimate(2, 0.01);
  scheduler.set_estimate(3, -1);
  scheduler.set_estimate(3, std::numeric_limits<double>::quiet_NaN());
  scheduler.set_estimate(3, 1e300);
  begin(scheduler, 10000, 10);
  const auto trials = [&](WorkerId w) {
    const auto what = scheduler.next(w, 0);
    return what ? what->networks.size() * what->trials : 0;
  };
  EXPECT_EQ(trials(1), 50U) << "50 ms of 1 ms";
  EXPECT_EQ(trials(2), 5U) << "50 ms of 10 ms";
  EXPECT_EQ(trials(3), 500U) << "as many as of the first guess";
  EXPECT_EQ(scheduler.trial_seconds(1), 0.001);
  EXPECT_EQ(scheduler.trial_seconds(3), 0);
}

TEST(Scheduler, CreditBoundsWhatAWorkerHoldsAndGrowsWithDistance) {
  Scheduler scheduler(plain());
  scheduler.join(1, 3);
  scheduler.join(2, 3);
  begin(scheduler, 100000, 5);
  const auto fill = [&](WorkerId w) {
    int held = 0;
    while (scheduler.next(w, 0)) ++held;
    return held;
  };
  EXPECT_EQ(fill(1), 6);
  scheduler.set_round_trip(2, 0.2);
  EXPECT_GT(fill(2), 6) << "a worker 200 ms away runs dry on two tasks a slot";
}

// Heartbeats wait behind the tasks on the connection. If credit followed them, every full queue would ask for
// a fuller one, until megabytes wait for one worker that has no processor to read them with.
TEST(Scheduler, CreditDoesNotGrowByAWorkersOwnQueue) {
  Scheduler scheduler(plain());
  scheduler.join(1, 1);
  begin(scheduler, 100000, 5);
  scheduler.set_round_trip(1, 1e-5);
  for (int i = 0; i < 8; ++i) scheduler.set_round_trip(1, 0.4);  // queued behind work
  int held = 0;
  while (scheduler.next(1, 0)) ++held;
  EXPECT_EQ(held, 2);
  for (int i = 0; i < 40; ++i) scheduler.set_round_trip(1, 0.4);  // it really is far away now
  EXPECT_TRUE(scheduler.next(1, 0)) << "a short round trip long ago must be forgotten";
}

TEST(Scheduler, BytesInFlightToOneWorkerAreBounded) {
  constexpr std::size_t kNetwork = 20000;
  Scheduler scheduler(plain());
  scheduler.join(1, 1);
  scheduler.set_round_trip(1, 0.5);
  for (int round = 0; round < 3; ++round) {
    begin(scheduler, 20000, 1, kNetwork);
    std::vector<Assignment> held;
    std::size_t bytes = 0;
    while (const auto what = scheduler.next(1, 0)) {
      bytes += what->networks.size() * kNetwork;
      held.push_back(*what);
    }
    EXPECT_GT(held.size(), 2U) << "a distant worker gets more than the least credit";
    EXPECT_LE(bytes, 6U << 20) << "in round " << round;
    for (const Assignment& what : held) scheduler.result(1, what.task, 1e-6);
    EXPECT_TRUE(scheduler.next(1, 0)) << "what came back makes room, in round " << round;
  }
}

TEST(Scheduler, LostWorkersTasksGoBackAtOnceAndLateResultsAreUnknown) {
  Scheduler scheduler(plain());
  scheduler.join(1, 1);
  begin(scheduler, 4, 1);
  const auto first = scheduler.next(1, 0);
  ASSERT_TRUE(first);
  scheduler.leave(1, Departure::kLeft);
  EXPECT_FALSE(scheduler.find(1, first->task, first->attempt));
  scheduler.join(2, 1);
  std::set<std::uint32_t> again;
  while (const auto what = scheduler.next(2, 0)) {
    again.insert(what->networks.begin(), what->networks.end());
    scheduler.result(2, what->task, 1e-3);
  }
  EXPECT_EQ(again.size(), 4U);
  EXPECT_TRUE(scheduler.finished());
  EXPECT_EQ(scheduler.counts().strikes, 0U) << "leaving is no strike";
}

TEST(Scheduler, StragglersAreCopiedOnlyWhenTheQueueIsDryAndTheFirstResultCounts) {
  SchedulerOptions options;
  options.credit = 1;
  Scheduler scheduler(options);
  scheduler.join(1, 1);
  scheduler.join(2, 1);
  begin(scheduler, 2, 1, 1 << 20);
  const auto slow = scheduler.next(1, 0);
  const auto quick = scheduler.next(2, 0);
  ASSERT_TRUE(slow && quick);
  scheduler.started(1, slow->task, slow->attempt, 0);
  scheduler.result(2, quick->task, 1e-3);
  EXPECT_FALSE(scheduler.next(2, 0.001)) << "too early to copy";
  const auto copy = scheduler.next(2, 1.0);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->task, slow->task);
  EXPECT_NE(copy->attempt, slow->attempt);
  const auto accepted = scheduler.result(2, copy->task, 1e-3);
  EXPECT_EQ(accepted.complete, slow->networks);
  EXPECT_EQ(accepted.cancel, std::vector<WorkerId>{1});
  EXPECT_FALSE(scheduler.find(1, slow->task, slow->attempt)) << "the second result would be counted twice";
  EXPECT_TRUE(scheduler.finished());
}

// A network that kills its worker, among innocents that share tasks and workers with it.
TEST(Scheduler, OnlyTheNetworkThatKillsIsPoisoned) {
  SchedulerOptions options = plain();
  options.poison_strikes = 3;
  Scheduler scheduler(options);
  WorkerId next_worker = 1;
  std::set<WorkerId> alive;
  const auto hire = [&] {
    scheduler.join(next_worker, 2);
    alive.insert(next_worker++);
  };
  hire();
  hire();
  begin(scheduler, 40, 5);
  constexpr std::uint32_t kKiller = 17;
  std::vector<Poisoned> poisoned;
  std::size_t evaluated = 0;
  for (int round = 0; round < 200 && !scheduler.finished(); ++round) {
    for (const WorkerId w : std::vector<WorkerId>(alive.begin(), alive.end())) {
      std::vector<Assignment> held;
      while (const auto what = scheduler.next(w, round)) held.push_back(*what);
      bool dies = false;
      for (const Assignment& what : held) {
        scheduler.started(w, what.task, what.attempt, round);
        dies |= std::find(what.networks.begin(), what.networks.end(), kKiller) != what.networks.end();
      }
      if (dies) {
        scheduler.leave(w, Departure::kDied);
        alive.erase(w);
        hire();
      } else {
        for (const Assignment& what : held) evaluated += scheduler.result(w, what.task, 1e-3).complete.size();
      }
      for (const Poisoned& p : scheduler.take_poisoned()) poisoned.push_back(p);
    }
  }
  EXPECT_TRUE(scheduler.finished());
  ASSERT_EQ(poisoned.size(), 1U);
  EXPECT_EQ(poisoned[0].network, kKiller);
  EXPECT_EQ(poisoned[0].workers, 3U);
  EXPECT_EQ(evaluated, 39U);
}

TEST(Scheduler, ANetworkThatKillsBeforeItsStartIsHeardOfIsStillFound) {
  Scheduler scheduler(plain());
  begin(scheduler, 1, 1);
  int deaths = 0;
  for (WorkerId w = 1; w < 50 && !scheduler.finished(); ++w) {
    scheduler.join(w, 1);
    const auto what = scheduler.next(w, w);
    ASSERT_TRUE(what);
    // A suspect announces its start before it can do harm; others die unheard.
    if (what->suspect) scheduler.started(w, what->task, what->attempt, w);
    scheduler.leave(w, Departure::kDied);
    ++deaths;
  }
  EXPECT_TRUE(scheduler.finished());
  EXPECT_EQ(scheduler.take_poisoned().size(), 1U);
  EXPECT_LE(deaths, 5);
}

TEST(Scheduler, ATaskPastItsDeadlineCostsASlotAndGoesElsewhere) {
  SchedulerOptions options = plain();
  options.task_deadline = 1;
  Scheduler scheduler(options);
  scheduler.join(1, 2);
  begin(scheduler, 1, 1);
  const auto what = scheduler.next(1, 0);
  ASSERT_TRUE(what);
  scheduler.started(1, what->task, what->attempt, 0);
  EXPECT_TRUE(scheduler.expire(0.9).empty());
  EXPECT_EQ(scheduler.expire(1.1).size(), 1U);
  EXPECT_EQ(scheduler.slots(1), 1U);
  scheduler.join(2, 1);
  EXPECT_FALSE(scheduler.next(1, 1.2)) << "not to the worker it hangs on";
  EXPECT_TRUE(scheduler.next(2, 1.2));
}

// Ctrl-Z, a minute, fg: nothing hung.
TEST(Scheduler, ATimeInWhichTheMasterStoodStillCountsForNoDeadline) {
  SchedulerOptions options = plain();
  options.task_deadline = 1;
  Scheduler scheduler(options);
  scheduler.join(1, 1);
  begin(scheduler, 1, 1);
  const auto what = scheduler.next(1, 0);
  ASSERT_TRUE(what);
  scheduler.started(1, what->task, what->attempt, 0.2);
  scheduler.excuse(60, 60.3);
  EXPECT_TRUE(scheduler.expire(60.3).empty()) << "ran for 0.1 s";
  EXPECT_TRUE(scheduler.expire(61.1).empty()) << "ran for 0.9 s";
  EXPECT_EQ(scheduler.expire(61.3).size(), 1U) << "ran for 1.1 s";
}

// Whatever happens to workers, all work gets done, once.
TEST(Scheduler, SurvivesAnythingThatWorkersDo) {
  Random random(1, Purpose::kTestHarness);
  for (int round = 0; round < 30; ++round) {
    SchedulerOptions options;
    options.poison_strikes = 1000000;
    Scheduler scheduler(options);
    const std::uint32_t networks = 1 + random.below(60), trials = 1 + random.below(40);
    begin(scheduler, networks, trials);
    struct Held {
      WorkerId worker;
      Assignment what;
    };
    std::vector<Held> held;
    std::set<WorkerId> alive;
    WorkerId next_worker = 1;
    std::vector<int> completed(networks, 0);
    double now = 0;
    for (int step = 0; step < 20000 && !scheduler.finished(); ++step) {
      now += random.uniform(0, 0.01);
      const std::uint32_t dice = random.below(20);
      if (alive.empty() || (dice == 0 && alive.size() < 6)) {
        scheduler.join(next_worker, 1 + random.below(4));
        alive.insert(next_worker++);
      } else if (dice == 1 && alive.size() > 1) {
        const WorkerId w = *alive.begin();
        alive.erase(w);
        scheduler.leave(w, random.chance(0.5) ? Departure::kDied : Departure::kLeft);
        std::erase_if(held, [&](const Held& h) { return h.worker == w; });
      } else if (dice < 10) {
        const WorkerId w = *std::next(alive.begin(), random.below(static_cast<std::uint32_t>(alive.size())));
        if (auto what = scheduler.next(w, now)) {
          if (random.chance(0.7)) scheduler.started(w, what->task, what->attempt, now);
          held.push_back({w, *what});
        }
      } else if (!held.empty()) {
        const std::uint32_t at = random.below(static_cast<std::uint32_t>(held.size()));
        const Held h = held[at];
        held.erase(held.begin() + at);
        scheduler.came_back(h.worker, h.what.task, h.what.attempt, now);
        if (scheduler.find(h.worker, h.what.task, h.what.attempt))
          for (const std::uint32_t n :
               scheduler.result(h.worker, h.what.task, random.uniform(0, 0.01)).complete)
            ++completed[n];
      }
    }
    ASSERT_TRUE(scheduler.finished()) << "round " << round;
    for (std::uint32_t i = 0; i < networks; ++i) EXPECT_EQ(completed[i], 1) << "network " << i;
  }
}

}  // namespace
}  // namespace evograsp::server

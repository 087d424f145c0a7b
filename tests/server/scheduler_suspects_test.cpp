// Networks that stop workers: whom they are given to, what counts, and when they are given up.
#include <gtest/gtest.h>

#include <map>

#include "common/random.h"
#include "server/scheduler.h"

namespace evograsp::server {
namespace {

constexpr std::uint64_t kHostA = 1, kHostB = 2;

// One network of one trial, three strikes; workers come and go by hand.
class Suspects : public ::testing::Test {
 protected:
  Suspects() {
    SchedulerOptions options;
    options.speculate = false;
    options.poison_strikes = 3;
    options.task_deadline = 1;
    scheduler_ = Scheduler(options);
    begin();
  }
  void begin() {
    scheduler_.begin(1, 1);
    scheduler_.add(0, 1000);
  }
  WorkerId join(std::uint64_t identity, std::uint64_t host) {
    scheduler_.join(++last_, 1, Party(identity, host));
    return last_;
  }
  // The worker takes the network, begins and is lost; false: it is not given it.
  bool lose(WorkerId worker, Departure departure) {
    const auto what = scheduler_.next(worker, 0);
    if (what) scheduler_.started(worker, what->task, what->attempt, 0);
    scheduler_.leave(worker, departure);
    return what.has_value();
  }
  // So many times over, the same worker is started again and lost.
  int lose_again(int times, std::uint64_t identity, std::uint64_t host, Departure departure) {
    int lost = 0;
    while (lost < times && !scheduler_.finished()) {
      if (!lose(join(identity, host), departure)) break;
      ++lost;
    }
    return lost;
  }

  Scheduler scheduler_{{}};
  WorkerId last_ = 0;
};

TEST_F(Suspects, AWorkerThatDiesAgainAndAgainIsOneWorker) {
  EXPECT_EQ(lose_again(11, 7, kHostA, Departure::kDied), 11);
  EXPECT_FALSE(scheduler_.finished()) << "one worker's deaths were counted as those of several";
  EXPECT_TRUE(scheduler_.take_poisoned().empty());
  const WorkerId other = join(8, kHostA);
  const auto what = scheduler_.next(other, 0);
  ASSERT_TRUE(what);
  EXPECT_EQ(scheduler_.result(other, what->task, 0.001).complete.size(), 1U);
  EXPECT_TRUE(scheduler_.finished());
}

TEST_F(Suspects, OnTheOnlyWorkerItIsGivenUpInTheEnd) {
  EXPECT_EQ(lose_again(1000, 7, kHostA, Departure::kDied), 12) << "4 x poison_strikes";
  const auto poisoned = scheduler_.take_poisoned();
  ASSERT_EQ(poisoned.size(), 1U);
  EXPECT_EQ(poisoned[0].workers, 1U);
  EXPECT_EQ(poisoned[0].hosts, 1U);
  EXPECT_EQ(poisoned[0].tries, 12U);
}

TEST_F(Suspects, ThreeWorkersOfTheOnlyHostAreEnough) {
  for (const std::uint64_t identity : {7, 8, 9}) {
    EXPECT_FALSE(scheduler_.finished());
    EXPECT_EQ(lose_again(1, identity, kHostA, Departure::kDied), 1);
  }
  ASSERT_TRUE(scheduler_.finished());
  EXPECT_EQ(scheduler_.take_poisoned()[0].workers, 3U);
}

TEST_F(Suspects, OneHostAloneDecidesNothingWhereOthersAre) {
  const WorkerId honest = join(1, kHostB);
  scheduler_.set_active(honest, false);  // its simulator does not stand yet
  for (const std::uint64_t identity : {7, 8, 9, 10})
    EXPECT_EQ(lose_again(1, identity, kHostA, Departure::kDied), 1);
  EXPECT_FALSE(scheduler_.finished()) << "four names on one machine";
  scheduler_.set_active(honest, true);
  EXPECT_FALSE(scheduler_.next(join(11, kHostA), 0)) << "another host is here to try it";
  const auto what = scheduler_.next(honest, 0);
  ASSERT_TRUE(what);
  EXPECT_TRUE(what->suspect);
  EXPECT_EQ(scheduler_.result(honest, what->task, 0.001).complete.size(), 1U);
}

TEST_F(Suspects, WhatKillsOnTwoHostsIsPoison) {
  const WorkerId b = join(1, kHostB);
  EXPECT_EQ(lose_again(1, 7, kHostA, Departure::kDied), 1);
  EXPECT_TRUE(lose(b, Departure::kDied)) << "the other host tries it next";
  EXPECT_FALSE(scheduler_.finished());
  const WorkerId again = join(1, kHostB), fresh = join(8, kHostA);
  EXPECT_FALSE(scheduler_.next(again, 0)) << "a worker that has not tried it is here";
  EXPECT_TRUE(lose(fresh, Departure::kDied));
  ASSERT_TRUE(scheduler_.finished());
  const auto poisoned = scheduler_.take_poisoned();
  EXPECT_EQ(poisoned[0].workers, 3U);
  EXPECT_EQ(poisoned[0].hosts, 2U);
}

TEST_F(Suspects, SilenceIsNoStrike) {
  EXPECT_EQ(lose_again(5, 7, kHostA, Departure::kSilent), 5);
  for (const std::uint64_t identity : {8, 9, 10})
    EXPECT_EQ(lose_again(1, identity, kHostA, Departure::kSilent), 1);
  EXPECT_FALSE(scheduler_.finished());
  EXPECT_EQ(scheduler_.counts().strikes, 0U);
}

// Whoever is frozen by it for good comes back only when somebody restarts it.
TEST_F(Suspects, WhatFreezesWorkersWhollyIsGivenUpInTheEnd) {
  EXPECT_EQ(lose_again(1000, 7, kHostA, Departure::kSilent), 14) << "two until it is suspect, then 12";
  EXPECT_EQ(scheduler_.take_poisoned().size(), 1U);
  EXPECT_EQ(scheduler_.counts().strikes, 0U);
}

TEST_F(Suspects, AHangIsAStrikeOfItsWorkerOnce) {
  for (int i = 0; i < 3; ++i) {
    const WorkerId worker = join(7, kHostA);
    const auto what = scheduler_.next(worker, 10 * i);
    ASSERT_TRUE(what);
    scheduler_.started(worker, what->task, what->attempt, 10 * i);
    EXPECT_EQ(scheduler_.expire(10 * i + 5).size(), 1U);
    scheduler_.leave(worker, Departure::kLeft);
  }
  EXPECT_EQ(scheduler_.counts().strikes, 3U);
  EXPECT_FALSE(scheduler_.finished()) << "one worker's hangs were counted as those of several";
}

// The one who may audit has been struck down by it, the one who has not may not audit: the first must do.
TEST_F(Suspects, AnAuditOfASuspectIsNotStuck) {
  EXPECT_EQ(lose_again(1, 8, kHostB, Departure::kDied), 1);
  const WorkerId first = join(7, kHostA), second = join(8, kHostB);
  const auto what = scheduler_.next(first, 0);
  ASSERT_TRUE(what);
  scheduler_.audit(1, {0, 0, 1}, {Party(7, kHostA)});
  EXPECT_TRUE(scheduler_.result(first, what->task, 0.001).complete.empty());
  EXPECT_FALSE(scheduler_.next(first, 0));
  const auto audit = scheduler_.next(second, 0);
  ASSERT_TRUE(audit);
  EXPECT_EQ(scheduler_.result(second, audit->task, 0.001).complete.size(), 1U);
}

// Workers of a few hosts come, work, die, fall silent and come back under their names; some networks kill, a
// third is audited.
class Crowd {
 public:
  explicit Crowd(std::uint64_t seed) : random_(seed, Purpose::kTestHarness) {
    SchedulerOptions options;
    options.poison_strikes = 1 + random_.below(3);
    scheduler_ = Scheduler(options);
    parties_ = 1 + random_.below(6);
    hosts_ = 1 + random_.below(3);
    scheduler_.begin(kNetworks, 4);
    for (std::uint32_t i = 0; i < kNetworks; ++i) scheduler_.add(i, 1000);
  }
  bool runs_to_its_end() {
    for (int step = 0; step < 20000 && !scheduler_.finished(); ++step) {
      now_ += 1;
      const std::uint32_t party = random_.below(parties_);
      if (!here_.contains(party))
        come(party);
      else if (random_.chance(0.02))
        go(party, random_.chance(0.5) ? Departure::kSilent : Departure::kLeft);
      else
        work(party);
      for (const Poisoned& poisoned : scheduler_.take_poisoned()) given_up_.push_back(poisoned.network);
      scheduler_.skip_audits();
    }
    return scheduler_.finished();
  }
  static bool kills(std::uint32_t network) { return network % 10 == 3; }
  const std::vector<std::uint32_t>& given_up() const { return given_up_; }

 private:
  static constexpr std::uint32_t kNetworks = 30;

  void come(std::uint32_t party) {
    here_[party] = ++last_;
    scheduler_.join(last_, 1 + random_.below(2), Party(party, party % hosts_));
  }
  void go(std::uint32_t party, Departure departure) {
    scheduler_.leave(here_.at(party), departure);
    here_.erase(party);
  }
  void work(std::uint32_t party) {
    const WorkerId worker = here_.at(party);
    const auto what = scheduler_.next(worker, now_);
    if (!what) return;
    scheduler_.started(worker, what->task, what->attempt, now_);
    for (const std::uint32_t network : what->networks)
      if (kills(network)) return go(party, Departure::kDied);
    scheduler_.came_back(worker, what->task, what->attempt, now_);
    for (const std::uint32_t network : what->networks)
      if (what->audit == 0 && network % 3 == 0)
        scheduler_.audit(++audits_, {network, what->first_trial, what->trials},
                         {Party(party, party % hosts_)});
    scheduler_.result(worker, what->task, 0.001);
  }

  Random random_;
  Scheduler scheduler_{{}};
  std::uint32_t parties_ = 1, hosts_ = 1, audits_ = 0;
  std::map<std::uint32_t, WorkerId> here_;
  WorkerId last_ = 0;
  double now_ = 0;
  std::vector<std::uint32_t> given_up_;
};

TEST(Suspicion, WhateverWorkersDoTheWorkEndsAndOnlyWhatKillsIsGivenUp) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Crowd crowd(seed);
    ASSERT_TRUE(crowd.runs_to_its_end()) << "seed " << seed;
    EXPECT_EQ(crowd.given_up().size(), 3U) << "seed " << seed;
    for (const std::uint32_t network : crowd.given_up())
      EXPECT_TRUE(Crowd::kills(network)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace evograsp::server

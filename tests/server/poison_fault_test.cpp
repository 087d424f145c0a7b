// Genomes that kill or hang the worker that evaluates them: given up after a few workers, kept for replay,
// and the run goes on.
#include <gtest/gtest.h>

#include <array>

#include "server/store_reader.h"
#include "tests/server/real_run.h"

namespace evograsp {
namespace {

using testing::eventually;
using testing::Process;
using testing::RealRun;

constexpr int kVictim = 5;           // a genome of the first generation
constexpr int kWatchdogTurns = 120;  // of 10 ms, that a stopped process is left alone

class Poison : public RealRun {
 protected:
  Poison() { generations_ = 6; }

  std::vector<server::PoisonRecord> poisons() const {
    auto reader = server::StoreReader::open(run_dir());
    return reader ? (*reader)->poisons().value_or(std::vector<server::PoisonRecord>{})
                  : std::vector<server::PoisonRecord>{};
  }
  // Workers with the fault, each started again when it has died (as systemd or a batch system would), until
  // the server ends. Gives how many have died by a signal or left with an error. steady: each keeps its name.
  int keep_alive(Process& server, const std::string& fault, int workers, bool steady = false,
                 const std::string& host = {}) {
    std::vector<std::unique_ptr<Process>> all(static_cast<std::size_t>(workers));
    std::vector<int> stopped(all.size());
    int started = 0, dead = 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(40);
    while (!server.ended() && std::chrono::steady_clock::now() < end) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i] && is_stopped(*all[i]) && ++stopped[i] > kWatchdogTurns) all[i]->finish(SIGKILL);
        if (all[i] && !all[i]->ended()) continue;
        dead += all[i] != nullptr ? 1 : 0;
        stopped[i] = 0;
        all[i] = start_faulty("mortal-" + std::to_string(steady ? i : started++), fault, host);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return dead;
  }
  static bool is_stopped(const Process& process) {
    const std::string stat = testing::read_file("/proc/" + std::to_string(process.pid()) + "/stat");
    const auto name_end = stat.rfind(')');
    return name_end != std::string::npos && stat.compare(name_end, 3, ") T") == 0;
  }
  // A worker that is at a slow task is killed or frozen until the master gives it up, so many times, always
  // the same one; then one that is well does the rest.
  void lose_the_same_worker(Process& server, int times, bool freeze) {
    for (int i = 0; i < times; ++i) {
      const auto worker = start_faulty("unlucky", "sleep:5");
      wait_for_welcome(*worker);
      std::this_thread::sleep_for(std::chrono::milliseconds(150));
      if (freeze) worker->signal(SIGSTOP);
      const auto lost = [&] { return events("worker_lost").size() > static_cast<std::size_t>(i); };
      EXPECT_TRUE(!freeze || eventually(lost)) << server.log();
      worker->finish(SIGKILL);
      std::filesystem::remove(log("unlucky"));  // the next one's welcome is not this one's
    }
    const auto worker = start_worker("steady", 2);
    EXPECT_EQ(server.finish(), 0) << server.log();
    EXPECT_TRUE(poisons().empty()) << server.log();
    EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
  }
  void expect_one_poison(const Process& server) {
    const auto all = poisons();
    ASSERT_EQ(all.size(), 1U) << server.log();
    EXPECT_EQ(all[0].genome, static_cast<std::uint64_t>(kVictim));
    const auto told = events("poison");
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("genome " + std::to_string(kVictim) + " of generation 0 is scored zero"),
              std::string::npos)
        << told[0];
    auto reader = server::StoreReader::open(run_dir());
    ASSERT_TRUE(reader);
    EXPECT_EQ((*reader)->generations(0, 100)->size(), 6U) << "the run did not go on";
  }
};

TEST_F(Poison, AGenomeThatKillsWorkersIsScoredZeroAndTheRunGoesOn) {
  Process server("evograsp-server", server_arguments(), log("server"));
  const int dead = keep_alive(server, "abort:" + std::to_string(kVictim), 2);
  EXPECT_EQ(server.finish(), 0) << server.log();
  expect_one_poison(server);
  EXPECT_GE(dead, 3);
  EXPECT_LE(dead, 8) << "the innocent were tried with the guilty for too long";
}

TEST_F(Poison, AGenomeThatHangsIsGivenUpAtItsDeadline) {
  Process server("evograsp-server", server_arguments({"dispatch.task_deadline=1.5"}), log("server"));
  keep_alive(server, "hang:" + std::to_string(kVictim), 2);
  EXPECT_EQ(server.finish(), 0) << server.log();
  expect_one_poison(server);
  EXPECT_GE(events("hung").size(), 3U);
}

TEST_F(Poison, TheSameGenomeIsPoisonWhoeverDies) {
  {
    Process server("evograsp-server", server_arguments(), log("server"));
    keep_alive(server, "abort:" + std::to_string(kVictim), 1);
    EXPECT_EQ(server.finish(), 0) << server.log();
  }
  const std::string one = champion();
  std::filesystem::remove_all(run_dir());
  Process server("evograsp-server", server_arguments(), log("server"));
  keep_alive(server, "abort:" + std::to_string(kVictim), 3);
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(one));
}

TEST_F(Poison, OneWorkerKilledAgainAndAgainIsNotSeveral) {
  Process server("evograsp-server", server_arguments(), log("server"));
  lose_the_same_worker(server, 6, false);
}

TEST_F(Poison, OneWorkerFrozenAgainAndAgainIsNoStrike) {
  Process server("evograsp-server",
                 server_arguments({"net.silence_seconds=0.4", "net.heartbeat_seconds=0.1"}), log("server"));
  lose_the_same_worker(server, 5, true);
}

// Three processes that die of everything on one machine, started again and again; one on another is well.
TEST_F(Poison, OneBadMachineDoesNotChangeTheChampion) {
  Process server("evograsp-server", server_arguments(), log("server"));
  const auto good = start_faulty("good", "sleep:0.02", "good-machine");
  wait_for_welcome(*good);
  const int dead = keep_alive(server, "die", 3, false, "bad-machine");
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_GE(dead, 4) << "the bad machine was hardly given anything";
  EXPECT_TRUE(poisons().empty()) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
}

TEST_F(Poison, WithOneWorkerAloneTheRunStillEnds) {
  Process server("evograsp-server", server_arguments(), log("server"));
  const int dead = keep_alive(server, "abort:" + std::to_string(kVictim), 1, true);
  EXPECT_EQ(server.finish(), 0) << server.log();
  expect_one_poison(server);
  EXPECT_GE(dead, 12);
  EXPECT_LE(dead, 16);
  EXPECT_NE(events("poison")[0].find("1 worker on 1 host"), std::string::npos) << events("poison")[0];
}

// No heartbeats either: only the service manager's watchdog brings the worker back.
TEST_F(Poison, AGenomeThatFreezesWholeWorkersIsGivenUpAndTheRunEnds) {
  Process server(
      "evograsp-server",
      server_arguments({"net.silence_seconds=0.4", "net.heartbeat_seconds=0.1", "dispatch.poison_strikes=1"}),
      log("server"));
  keep_alive(server, "freeze:" + std::to_string(kVictim), 1, true);
  EXPECT_EQ(server.finish(), 0) << server.log();
  expect_one_poison(server);
  EXPECT_NE(events("poison")[0].find("in 4 tries"), std::string::npos) << events("poison")[0];
}

TEST_F(Poison, IsReplayedFromTheRunFolder) {
  Process server("evograsp-server", server_arguments(), log("server"));
  keep_alive(server, "abort:" + std::to_string(kVictim), 2);
  EXPECT_EQ(server.finish(), 0) << server.log();
  Process replay("evograsp", {"sim", "--replay", run_dir().string()}, log("replay"));
  EXPECT_EQ(replay.finish(), 0) << replay.log();
  EXPECT_NE(replay.log().find("genome 5 of generation 0"), std::string::npos) << replay.log();
  EXPECT_NE(replay.log().find("trial 3 of 3: seed "), std::string::npos) << replay.log();
  Process other("evograsp", {"sim", "--replay", run_dir().string(), "--genome", "77"}, log("other"));
  EXPECT_EQ(other.finish(), static_cast<int>(ErrorCode::kNotFound));
  EXPECT_NE(other.log().find("these are: 5 (generation 0)"), std::string::npos) << other.log();
}

TEST_F(Poison, PreemptionIsNoStrike) {
  Process server("evograsp-server", server_arguments(), log("server"));
  // Told to go while a slow task runs, and killed before it could finish: three times over, the same tasks.
  for (int i = 0; i < 4; ++i) {
    const auto worker = start_faulty("preempted-" + std::to_string(i), "sleep:5");
    wait_for_welcome(*worker);
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    worker->signal(SIGTERM);
    ASSERT_TRUE(eventually([&] { return worker->log().find("draining") != std::string::npos; }))
        << worker->log();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    worker->finish(SIGKILL);
  }
  const auto worker = start_worker("steady", 2);
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_TRUE(poisons().empty());
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
}

}  // namespace
}  // namespace evograsp

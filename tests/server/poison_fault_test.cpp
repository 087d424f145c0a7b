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

constexpr int kVictim = 5;  // a genome of the first generation

class Poison : public RealRun {
 protected:
  Poison() { generations_ = 6; }

  std::vector<server::PoisonRecord> poisons() const {
    auto reader = server::StoreReader::open(run_dir());
    return reader ? (*reader)->poisons().value_or(std::vector<server::PoisonRecord>{})
                  : std::vector<server::PoisonRecord>{};
  }
  // Workers with the fault, each started again when it has died (as systemd or a batch system would), until
  // the server ends. Gives how many have died by a signal or left with an error.
  int keep_alive(Process& server, const std::string& fault, int workers) {
    std::vector<std::unique_ptr<Process>> all(static_cast<std::size_t>(workers));
    int started = 0, dead = 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(40);
    while (!server.ended() && std::chrono::steady_clock::now() < end) {
      for (auto& worker : all) {
        if (worker && !worker->ended()) continue;
        dead += worker != nullptr ? 1 : 0;
        worker = start_faulty("mortal-" + std::to_string(started++), fault);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return dead;
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
  Process server("evograsp-server", server_arguments({"dispatch.task_deadline=0.5"}), log("server"));
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

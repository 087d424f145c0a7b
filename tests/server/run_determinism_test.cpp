// One config and one seed give one champion, byte for byte, whoever does the work and whatever happens to
// them.
#include <gtest/gtest.h>

#include "tests/server/real_run.h"

namespace evograsp {
namespace {

using testing::champion_of;
using testing::eventually;
using testing::Process;

const std::string& reference() {
  static const std::string bytes = champion_of(testing::small_config(), {1});
  return bytes;
}

TEST(RunDeterminism, TheReferenceIsAValidatedChampion) {
  proto::Champion champion;
  ASSERT_TRUE(champion.ParseFromString(reference()));
  EXPECT_EQ(champion.validation_trials(), 6U);
  EXPECT_EQ(champion.network().outputs(), 7U);
  EXPECT_LT(champion.generation(), 40U);
}

TEST(RunDeterminism, TwoSlotsGiveTheBytesOfOne) {
  EXPECT_EQ(sha256_hex(champion_of(testing::small_config(), {2})), sha256_hex(reference()));
}

TEST(RunDeterminism, TwoWorkersGiveTheBytesOfOne) {
  EXPECT_EQ(champion_of(testing::small_config(), {1, 1}), reference());
}

TEST(RunDeterminism, OtherTaskSizesGiveTheSameBytes) {
  proto::Config config = testing::small_config();
  config.mutable_dispatch()->set_task_seconds(0.0002);
  config.mutable_dispatch()->set_credit(7);
  EXPECT_EQ(champion_of(config, {3}), reference());
}

TEST(RunDeterminism, AnotherSeedGivesAnotherChampion) {
  proto::Config config = testing::small_config();
  config.mutable_run()->set_seed(config.run().seed() + 1);
  EXPECT_NE(champion_of(config, {2}), reference());
}

using RealProcesses = testing::RealRun;

TEST_F(RealProcesses, WorkersKilledOnTheWayChangeNothing) {
  Process server("evograsp-server", server_arguments(), log("server"));
  std::vector<std::unique_ptr<Process>> workers;
  workers.push_back(start_faulty("steady", "sleep:0.02"));  // slow, so that the others are wanted
  for (int i = 0; i < 3; ++i) {
    auto victim = start_worker("victim-" + std::to_string(i));
    ASSERT_TRUE(eventually([&] { return victim->log().find("welcome") != std::string::npos; }))
        << server.log();
    std::this_thread::sleep_for(std::chrono::milliseconds(60 * (i + 1)));
    victim->finish(SIGKILL);
  }
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(reference()));
}

TEST_F(RealProcesses, AServerKilledAndResumedGivesTheSameBytes) {
  auto worker = start_worker("worker", 2);
  const auto generations_done = [&](const Process& server) {
    const std::string text = server.log();
    int count = 0;
    for (std::size_t at = 0; (at = text.find("generation ", at)) != std::string::npos; ++at) ++count;
    return count;
  };
  {
    Process server("evograsp-server", server_arguments(), log("first"));
    ASSERT_TRUE(eventually([&] { return generations_done(server) >= 1; })) << server.log();
    server.finish(SIGKILL);
  }
  {
    Process server("evograsp-server", {"--resume", run_dir().string(), "--listen", endpoint_, "--http", ""},
                   log("second"));
    ASSERT_TRUE(eventually([&] { return generations_done(server) >= 1; })) << server.log();
    server.finish(SIGKILL);
  }
  Process server("evograsp-server", {"--resume", run_dir().string(), "--listen", endpoint_, "--http", ""},
                 log("third"));
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(reference()));
}

TEST_F(RealProcesses, AServerToldToStopSaysHowToGoOnAndDoes) {
  auto worker = start_worker("worker", 2);
  {
    Process server("evograsp-server", server_arguments(), log("first"));
    ASSERT_TRUE(eventually([&] { return server.log().find("generation ") != std::string::npos; }))
        << server.log();
    server.signal(SIGTERM);
    const int code = server.finish();
    EXPECT_TRUE(code == 130 || code == 0) << server.log();
    if (code == 130) {
      EXPECT_NE(server.log().find("--resume"), std::string::npos);
    }
  }
  Process server("evograsp-server", {"--resume", run_dir().string(), "--listen", endpoint_, "--http", ""},
                 log("second"));
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(reference()));
  worker->signal(SIGTERM);
  EXPECT_EQ(worker->finish(), 0) << worker->log();
}

}  // namespace
}  // namespace evograsp

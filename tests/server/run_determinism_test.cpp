// One config and one seed give one champion, byte for byte, whoever does the work and whatever happens to
// them.
#include <gtest/gtest.h>

#include "server/champion_file.h"
#include "tests/server/cluster.h"

namespace evograsp {
namespace {

using testing::champion_of;
using testing::eventually;
using testing::Process;
using testing::TempDir;

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
  EXPECT_EQ(champion_of(testing::small_config(), {2}), reference());
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

// Real processes, because only they can be killed.
class RealProcesses : public ::testing::Test {
 protected:
  std::vector<std::string> server_arguments() const {
    std::vector<std::string> arguments = {"--config",  EVOGRASP_SOURCE_DIR "/configs/quick.txtpb",
                                          "--run-dir", run_dir().string(),
                                          "--listen",  endpoint_,
                                          "--http",    ""};
    for (const std::string& value : testing::small_run()) {
      if (value.rfind("net.", 0) == 0) continue;
      arguments.push_back("--set");
      arguments.push_back(value);
    }
    return arguments;
  }
  std::filesystem::path run_dir() const { return dir_.path() / "run"; }
  std::filesystem::path log(const char* name) const { return dir_.path() / name; }
  std::unique_ptr<Process> start_worker(const char* name, int slots = 1) const {
    return std::make_unique<Process>(
        "evograsp-worker", std::vector<std::string>{"--connect", endpoint_, "--slots", std::to_string(slots)},
        log(name));
  }
  std::string champion() const { return testing::read_file(run_dir() / server::kChampionFile); }

  TempDir dir_;
  std::string endpoint_ = testing::free_endpoint();
};

TEST_F(RealProcesses, WorkersKilledOnTheWayChangeNothing) {
  Process server("evograsp-server", server_arguments(), log("server"));
  std::vector<std::unique_ptr<Process>> workers;
  workers.push_back(start_worker("steady"));
  for (int i = 0; i < 3; ++i) {
    auto victim = start_worker("victim");
    ASSERT_TRUE(eventually([&] { return victim->log().find("welcome") != std::string::npos; }))
        << server.log();
    std::this_thread::sleep_for(std::chrono::milliseconds(60 * (i + 1)));
    victim->finish(SIGKILL);
  }
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(champion(), reference());
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
  EXPECT_EQ(champion(), reference());
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
  EXPECT_EQ(champion(), reference());
  worker->signal(SIGTERM);
  EXPECT_EQ(worker->finish(), 0) << worker->log();
}

}  // namespace
}  // namespace evograsp

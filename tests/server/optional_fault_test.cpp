// A server that is killed among optional trials (races, lifts) goes on with what it had journalled of them.
#include <gtest/gtest.h>

#include "tests/server/real_run.h"

namespace evograsp {
namespace {

using server::Evaluation;
using testing::eventually;
using testing::Process;

class OptionalTrials : public testing::RealRun {
 protected:
  OptionalTrials() { generations_ = 3; }

  // Every stage takes long enough to be killed in: one network a task, and a slow worker.
  std::vector<std::string> settings() const {
    return {"dispatch.task_seconds=0.0001", "race.keep=0.5",     "race.deviations=100",
            "lift.generations=3",           "lift.candidates=8", "lift.finalists=3",
            "dispatch.audit_share=0"};
  }
  // What this config comes to when nobody is killed.
  std::string expected() const {
    std::vector<std::string> all = testing::small_run(generations_);
    const std::vector<std::string> more = settings();
    all.insert(all.end(), more.begin(), more.end());
    const auto loaded = load_config(EVOGRASP_SOURCE_DIR "/configs/quick.txtpb", all);
    return loaded ? testing::champion_of(loaded->config, {2}) : "";
  }
  // Journalled evaluations of a stage of the generation that run.db would go on with.
  std::vector<Evaluation> journalled(const std::string& stage) const {
    std::vector<Evaluation> found;
    auto reader = server::StoreReader::open(run_dir());
    if (!reader) return found;
    const auto populations = (*reader)->populations();
    if (!populations || populations->empty()) return found;
    const auto all = (*reader)->optional_evaluations(populations->back());
    if (!all) return found;
    for (const Evaluation& e : *all)
      if (e.stage == stage) found.push_back(e);
    return found;
  }
};

TEST_F(OptionalTrials, AKillAmongThemLosesNothingThatWasJournalled) {
  auto worker = start_faulty("slow", "sleep:0.03");
  std::vector<std::string> arguments = server_arguments(settings());
  std::string last = "none";  // what the server before had journalled
  int server_number = 0;
  for (const std::string stage : {"race 1", "race 2", "lift", "final lift"}) {
    std::vector<Evaluation> kept;
    for (int attempt = 0; attempt < 5 && kept.empty(); ++attempt) {
      Process server("evograsp-server", arguments, log("server-" + std::to_string(++server_number)));
      ASSERT_TRUE(eventually([&] { return !journalled(stage).empty() || server.ended(); }, 40))
          << stage << "\n"
          << server.log();
      ASSERT_FALSE(server.ended()) << stage << "\n" << server.log();
      server.finish(SIGKILL);
      arguments = resume_arguments();
      kept = journalled(stage);
      if (last != "none") {
        EXPECT_NE(server.log().find(last), std::string::npos) << "does not say '" << last << "'\n"
                                                              << server.log();
      }
      last = std::to_string(kept.size()) + " evaluations of generation " +
             (kept.empty() ? "" : std::to_string(kept[0].generation)) + " (" + stage + ") were already done";
      if (kept.empty()) last = "none";  // the generation ended before the kill
    }
    ASSERT_FALSE(kept.empty()) << stage;
  }
  Process server("evograsp-server", arguments, log("last"));
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_NE(server.log().find(last), std::string::npos) << "does not say '" << last << "'\n" << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(expected()));
}

// A race that time bounds cannot be repeated elsewhere, but what run.db says of it decides a resumed one.
TEST_F(OptionalTrials, RoundsThatTimeAllowedAreKept) {
  std::vector<std::string> all = settings();
  all.push_back("race.rounds=6");
  all.push_back("race.keep=1");
  all.push_back("race.budget_seconds=0.9");
  auto worker = start_faulty("slow", "sleep:0.01");
  Process server("evograsp-server", server_arguments(all), log("server"));
  EXPECT_EQ(server.finish(), 0) << server.log();
  auto reader = server::StoreReader::open(run_dir());
  ASSERT_TRUE(reader);
  for (std::uint32_t g = 0; g < 3; ++g) {
    const auto rounds = (*reader)->race_rounds(g);
    ASSERT_TRUE(rounds && *rounds) << "generation " << g;
    // A round of 24 networks takes 0.24 s at least, so the budget ends with the fourth at the latest.
    EXPECT_LE(**rounds, 4U);
  }
  const auto records = (*reader)->generations(0, 10);
  ASSERT_TRUE(records);
}

}  // namespace
}  // namespace evograsp

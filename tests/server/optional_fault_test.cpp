// A server that is killed among optional trials (races, lifts) goes on with what it had journalled of them.
#include <gtest/gtest.h>

#include "server/store_tables.h"
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
  std::string expected() const { return undisturbed(settings()); }
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

// A race that time bounds cannot be repeated elsewhere: the run says so, and run.db how many rounds there
// were.
TEST_F(OptionalTrials, RoundsThatTimeAllowedAreKept) {
  std::vector<std::string> all = settings();
  for (const char* more : {"race.rounds=100", "race.keep=1", "race.budget_seconds=0.9", "lift.generations=0"})
    all.push_back(more);
  auto worker = start_faulty("slow", "sleep:0.01");
  Process server("evograsp-server", server_arguments(all), log("server"));
  EXPECT_EQ(server.finish(), 0) << server.log();
  auto reader = server::StoreReader::open(run_dir());
  ASSERT_TRUE(reader);
  const auto records = (*reader)->generations(0, 10);
  ASSERT_TRUE(records && records->size() == 3U);
  std::uint64_t before = 0;
  for (std::uint32_t g = 0; g < 3; ++g) {
    const auto rounds = (*reader)->race_rounds(g);
    ASSERT_TRUE(rounds && *rounds) << "generation " << g;
    // The generation's own trials and each round are a task at least, of 10 ms.
    EXPECT_LE(**rounds, 90U);
    // Who is beaten without any doubt leaves a round, so it may have fewer than 24.
    const std::uint64_t trials = (*records)[g].trials - before;
    EXPECT_EQ(trials > 24U * 3, **rounds > 0) << "generation " << g << ": " << trials << " trials";
    EXPECT_LE(trials, 24U * 3 * (1 + **rounds)) << "generation " << g;
    before = (*records)[g].trials;
  }
  EXPECT_EQ(events("time_bound").size(), 1U);
}

// What time had decided before the kill holds, though there would be no time now.
TEST_F(OptionalTrials, AResumedRaceHasTheRoundsThatWereDecided) {
  std::vector<std::string> all = settings();
  for (const char* more : {"race.budget_seconds=0.0001", "lift.generations=0"}) all.push_back(more);
  auto worker = start_faulty("slow", "sleep:0.03");
  {
    Process server("evograsp-server", server_arguments(all), log("first"));
    ASSERT_TRUE(eventually([&] {
      auto reader = server::StoreReader::open(run_dir());
      const auto done = reader ? (*reader)->evaluations(0) : Result<std::vector<Evaluation>>();
      return done && !done->empty();
    })) << server.log();
    server.finish(SIGKILL);
  }
  {
    auto database =
        server::Database::open(run_dir() / server::kStoreFile, server::Database::Mode::kReadWrite);
    ASSERT_TRUE(database);
    auto tables = server::StoreTables::prepare(**database);
    ASSERT_TRUE(tables && tables->put_race(0, 2));
  }
  Process server("evograsp-server", resume_arguments(), log("second"));
  EXPECT_EQ(server.finish(), 0) << server.log();
  auto reader = server::StoreReader::open(run_dir());
  ASSERT_TRUE(reader);
  const auto records = (*reader)->generations(0, 10);
  ASSERT_TRUE(records && records->size() == 3U);
  // The first round has at most the better half.
  EXPECT_GT((*records)[0].trials, (24U + 12) * 3) << "the two rounds that had been decided were not held";
  EXPECT_EQ((*records)[1].trials - (*records)[0].trials, 24U * 3) << "no time for any";
}

}  // namespace
}  // namespace evograsp

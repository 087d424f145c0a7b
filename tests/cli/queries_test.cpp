// The query commands as a user calls them, against a run folder and against a server.
#include "cli/queries.h"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "common/digest.h"
#include "server/api.h"
#include "tests/server/store_fixture.h"

namespace evograsp::cli {
namespace {

using nlohmann::json;
using server::RunFolder;

struct Said {
  int code = 0;
  std::string out, err;
  json document() const { return json::parse(out, nullptr, false); }
};

Said evograsp(std::vector<std::string> words) {
  words.insert(words.begin(), "evograsp");
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Said said;
  said.code = run(static_cast<int>(argv.size()), argv.data());
  said.out = testing::internal::GetCapturedStdout();
  said.err = testing::internal::GetCapturedStderr();
  return said;
}

// A server's run that says little and does as told.
class StillRun final : public server::RunControl {
 public:
  std::shared_ptr<const server::RunSnapshot> snapshot() const override {
    return std::make_shared<const server::RunSnapshot>(now);
  }
  Status pause() override { return did("pause"); }
  Status resume() override { return did("resume"); }
  Result<std::uint32_t> drain(const std::string& node, bool drained) override {
    told.push_back((drained ? "drain " : "undrain ") + node);
    return 1;
  }
  Status stop() override { return did("stop"); }
  Status checkpoint() override { return did("checkpoint"); }
  std::string log_level() const override { return "info"; }
  Status set_log_level(const std::string&) override { return {}; }
  server::RunSnapshot now;
  std::vector<std::string> told;

 private:
  Status did(const char* what) {
    told.push_back(what);
    return {};
  }
};

class Queries : public testing::Test {
 protected:
  Queries() : store_(std::move(*server::Store::create(folder_.path(), server::new_run()))) {
    for (std::uint32_t g = 0; g < 30; ++g) EXPECT_TRUE(server::commit(*store_, server::commit_of(g)));
    store_->saw_worker({"n1", "host", "0.1.0", "active", 4, 1.0, 11.0, 5, 250});
    store_->note({0, 0, server::Severity::kWarning, "worker_lost", "n2 \x1b[31mred"});
    EXPECT_TRUE(store_->flush());
    run_.now.name = "cube";
    run_.now.ready = true;
    run_.now.generations = 100;
    run_.now.committed = run_.now.generation = 30;
    run_.now.best = 0.79;
    server::ApiOptions options;
    options.listen = "127.0.0.1:0";
    options.run_dir = folder_.path();
    api_ = std::move(*server::ApiServer::create(options, run_));
    url_ = "http://127.0.0.1:" + std::to_string(api_->port());
  }
  std::string dir() const { return folder_.path().string(); }

  RunFolder folder_;
  std::unique_ptr<server::Store> store_;
  StillRun run_;
  std::unique_ptr<server::ApiServer> api_;
  std::string url_;
};

TEST_F(Queries, StatusOfAFolderShowsHowFarTheRunIs) {
  const Said said = evograsp({"status", "--run", dir()});
  EXPECT_EQ(said.code, 0);
  EXPECT_NE(said.out.find("cube: running, 30 of 100 generations"), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("best 0.7900"), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("█"), std::string::npos) << "a sparkline";
  EXPECT_EQ(said.err, "");
}

TEST_F(Queries, AServerAndItsFolderTellTheSame) {
  const json of_server = evograsp({"status", "--server", url_, "--json"}).document();
  const json of_folder = evograsp({"status", "--run", dir(), "--json"}).document();
  EXPECT_EQ(of_server["committed"], 30);
  EXPECT_EQ(of_server["fitness"]["best"], of_folder["fitness"]["best"]);
  for (const auto& [key, value] : of_folder.items()) EXPECT_TRUE(of_server.contains(key)) << key;
  const auto same = [&](std::vector<std::string> words) {
    std::vector<std::string> other = words;
    words.insert(words.end(), {"--server", url_, "--json"});
    other.insert(other.end(), {"--run", dir(), "--json"});
    return evograsp(words).document() == evograsp(other).document();
  };
  EXPECT_TRUE(same({"generations", "--last", "7"}));
  EXPECT_TRUE(same({"species", "--generation", "3"}));
  EXPECT_TRUE(same({"events"}));
  EXPECT_TRUE(same({"history"}));
}

TEST_F(Queries, AKilledRunIsInterruptedAndSaysHowToGoOn) {
  api_.reset();
  store_.reset();
  const Said said = evograsp({"status", "--run", dir()});
  EXPECT_NE(said.out.find("interrupted"), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("--resume " + dir()), std::string::npos) << said.out;
}

TEST_F(Queries, GenerationsShowsTheNewestUnlessAskedForAll) {
  EXPECT_EQ(evograsp({"generations", "--run", dir(), "--json"}).document()["generations"].size(), 20u);
  EXPECT_EQ(
      evograsp({"generations", "--run", dir(), "--last", "0", "--json"}).document()["generations"].size(),
      30u);
  const Said said = evograsp({"generations", "--run", dir(), "--last", "2"});
  EXPECT_EQ(std::ranges::count(said.out, '\n'), 4) << said.out;
}

TEST_F(Queries, HistoryAsCsvHoldsEveryGenerationExactly) {
  const Said said = evograsp({"history", "--csv", "--run", dir()});
  std::istringstream lines(said.out);
  std::string line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("generation,best,mean,")) << line;
  for (int g = 0; g < 30; ++g) {
    ASSERT_TRUE(std::getline(lines, line)) << g;
    EXPECT_TRUE(line.starts_with(std::to_string(g) + ",")) << line;
    EXPECT_EQ(std::stod(line.substr(line.find(',') + 1)), server::commit_of(g).record.best);
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(Queries, ChampionWritesTheBytesOrJson) {
  const std::string file = (folder_.path() / "c.pb").string();
  const Said said = evograsp({"champion", "--run", dir(), "--out", file});
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.err.find("not validated"), std::string::npos) << said.err;
  std::ifstream in(file, std::ios::binary);
  proto::Champion champion;
  ASSERT_TRUE(champion.ParseFromIstream(&in));
  EXPECT_EQ(champion.generation(), 29u) << "the best so far";
  EXPECT_EQ(champion.run_seed(), 18446744073709551615u);
  EXPECT_EQ(evograsp({"champion", "--run", dir(), "--format", "json"}).document()["generation"], 29);
  EXPECT_EQ(evograsp({"champion", "--run", dir(), "--json"}).document()["chosen"], false);
  EXPECT_EQ(evograsp({"champion", "--run", dir(), "--format", "xml"}).code, 2);
  EXPECT_EQ(evograsp({"champion", "--server", url_}).code, 4) << "the server has none yet";
}

TEST_F(Queries, AChosenChampionIsGivenOutByteForByte) {
  proto::Champion champion;
  champion.set_generation(12);
  champion.set_validation_trials(40);
  champion.mutable_network();
  store_->keep_champion(champion, {});
  ASSERT_TRUE(store_->flush());
  EXPECT_EQ(evograsp({"champion", "--run", dir(), "--format", "pb"}).out, deterministic_bytes(champion));
  EXPECT_EQ(evograsp({"champion", "--run", dir(), "--json"}).document()["chosen"], true);
  EXPECT_EQ(evograsp({"champion", "--run", dir(), "--json"}).document()["validation"]["trials"], 40);
}

TEST_F(Queries, RunsListsEveryRunBelow) {
  RunFolder other;
  std::filesystem::create_directories(other.path() / "deep");
  { ASSERT_TRUE(server::Store::create(other.path() / "deep" / "a", server::new_run())); }
  std::filesystem::create_directories(other.path() / "b");
  std::ofstream(other.path() / "b" / "run.db") << "no database at all, but long enough to look at";
  const Said said = evograsp({"runs", other.path().string(), "--json"});
  const json list = said.document()["runs"];
  ASSERT_EQ(list.size(), 2u) << said.out;
  EXPECT_EQ(list[0]["state"], "unreadable");
  EXPECT_EQ(list[1]["state"], "interrupted");
  EXPECT_EQ(evograsp({"runs", (other.path() / "none").string()}).code, 4);
}

TEST_F(Queries, SteeringReachesTheServerAndNeverAFolder) {
  for (const char* verb : {"pause", "resume", "stop", "checkpoint"})
    EXPECT_EQ(evograsp({verb, "--server", url_}).code, 0) << verb;
  EXPECT_EQ(run_.told, (std::vector<std::string>{"pause", "resume", "stop", "checkpoint"}));
  const Said said = evograsp({"stop", "--run", dir()});
  EXPECT_EQ(said.code, 2);
  EXPECT_NE(said.err.find("--server"), std::string::npos) << said.err;
}

TEST_F(Queries, WatchEndsWithTheRunAndPrintsALineAGeneration) {
  run_.now.state = server::RunState::kFinished;
  const Said said = evograsp({"watch", "--server", url_});
  EXPECT_EQ(said.code, 0);
  EXPECT_EQ(said.out, "finished  generation 30/100  best 0.790  mean 0.000  species 0  0 trials\n");
  run_.now.state = server::RunState::kRunning;
  const Said twice = evograsp({"watch", "--server", url_, "--count", "3", "--interval", "0.05", "--json"});
  EXPECT_EQ(std::ranges::count(twice.out, '\n'), 3) << "with --json a document a look";
}

TEST_F(Queries, EventsCannotSteerTheTerminal) {
  const Said said = evograsp({"events", "--run", dir()});
  EXPECT_NE(said.out.find("worker_lost"), std::string::npos);
  EXPECT_EQ(said.out.find('\x1b'), std::string::npos);
}

TEST_F(Queries, NobodyThereIsExitSixAndSaysWhatToDo) {
  api_.reset();
  for (const char* command :
       {"status", "watch", "workers", "generations", "species", "champion", "history", "stop"}) {
    const Said said = evograsp({command, "--server", url_});
    EXPECT_EQ(said.code, 6) << command;
    EXPECT_NE(said.err.find("evograsp-server"), std::string::npos) << said.err;
    EXPECT_EQ(said.out, "") << command;
  }
}

TEST_F(Queries, BadAddressesAndFoldersAreRefused) {
  for (const char* url : {"ftp://x", "http://", "http://127.0.0.1:99999999999", "http://127.0.0.1:x", "::::"})
    EXPECT_NE(evograsp({"status", "--server", url}).code, 0) << url;
  EXPECT_EQ(evograsp({"status", "--run", "/nonexistent"}).code, 4);
  EXPECT_EQ(evograsp({"status", "--run", dir(), "--server", url_}).code, 2);
}

TEST_F(Queries, TheEnvironmentNamesTheServer) {
  ::setenv("EVOGRASP_SERVER", url_.c_str(), 1);
  const Said said = evograsp({"workers", "--json"});
  ::unsetenv("EVOGRASP_SERVER");
  EXPECT_EQ(said.code, 0);
  EXPECT_EQ(said.document()["workers"].size(), 0u);
  EXPECT_EQ(evograsp({"workers", "--run", dir(), "--json"}).document()["workers"][0]["trials_per_second"],
            25);
}

TEST_F(Queries, EveryCommandsHelpHasAnExample) {
  for (const char* command : {"status", "watch", "workers", "generations", "species", "events", "history",
                              "champion", "runs", "pause", "resume", "stop", "checkpoint"}) {
    const Said said = evograsp({"help", command});
    EXPECT_EQ(said.code, 0) << command;
    EXPECT_NE(said.out.find("Example"), std::string::npos) << command;
  }
}

}  // namespace
}  // namespace evograsp::cli

// The map of grasps is a function of config and seed, whoever does the work and whatever happens to the
// server.
#include <gtest/gtest.h>

#include "server/archive_json.h"
#include "tests/server/real_run.h"

namespace evograsp {
namespace {

using server::EliteRecord;
using testing::eventually;
using testing::Process;

class Archives : public testing::RealRun {
 protected:
  Archives() { generations_ = 25; }

  static std::vector<std::string> settings(const std::string& kind) {
    return {"neat.archive.kind=" + kind, "neat.archive.x.bins=5", "neat.archive.y.bins=4",
            "neat.archive.again=0.1"};
  }
  static std::vector<EliteRecord> map_in(const std::filesystem::path& run_dir) {
    auto reader = server::StoreReader::open(run_dir);
    if (!reader) {
      ADD_FAILURE() << reader.error().message;
      return {};
    }
    auto elites = (*reader)->elites();
    EXPECT_TRUE(elites);
    return elites.value_or(std::vector<EliteRecord>());
  }
  // The map of a run that nobody disturbed, and its champion.
  struct End {
    std::vector<EliteRecord> map;
    std::string champion;
  };
  End undisturbed_run(const std::string& kind, int slots) const {
    std::vector<std::string> all = testing::small_run(generations_);
    const std::vector<std::string> more = settings(kind);
    all.insert(all.end(), more.begin(), more.end());
    const auto loaded = load_config(testing::kQuickConfig, all);
    if (!loaded) return {};
    testing::TempDir dir;
    zmq::context_t context(1);
    server::ServerOptions options = testing::server_options(loaded->config, dir.path() / "run");
    options.context = &context;
    auto server = server::Server::create(options);
    if (!server) return {};
    testing::WorkerThread worker(&context, "inproc://evograsp", slots);
    if (!(*server)->run()) return {};
    return {map_in(dir.path() / "run"), deterministic_bytes(*(*server)->champion())};
  }
};

void expect_equal(const std::vector<EliteRecord>& a, const std::vector<EliteRecord>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].cell, b[i].cell);
    EXPECT_EQ(a[i].genome, b[i].genome) << "cell " << a[i].cell;
    EXPECT_EQ(a[i].fitness, b[i].fitness) << "cell " << a[i].cell;
    EXPECT_EQ(a[i].judged, b[i].judged) << "cell " << a[i].cell;
    EXPECT_EQ(a[i].x_value, b[i].x_value) << "cell " << a[i].cell;
    EXPECT_EQ(a[i].y_value, b[i].y_value) << "cell " << a[i].cell;
    EXPECT_EQ(a[i].generation, b[i].generation) << "cell " << a[i].cell;
    EXPECT_EQ(a[i].genotype, b[i].genotype) << "cell " << a[i].cell;
    EXPECT_EQ(a[i].network, b[i].network) << "cell " << a[i].cell;
  }
}

TEST_F(Archives, TwoSlotsGiveTheMapOfOne) {
  for (const char* kind : {"MAP_ELITES", "NOVELTY"}) {
    const End one = undisturbed_run(kind, 1), two = undisturbed_run(kind, 2);
    EXPECT_GT(one.map.size(), 2U) << kind;
    expect_equal(one.map, two.map);
    EXPECT_EQ(sha256_hex(one.champion), sha256_hex(two.champion)) << kind;
  }
}

TEST_F(Archives, AServerKilledAndResumedGivesTheSameMap) {
  auto worker = start_worker("worker", 2);
  std::vector<std::string> arguments = server_arguments(settings("MAP_ELITES"));
  for (const std::string name : {"first", "second"}) {
    Process server("evograsp-server", arguments, log(name));
    ASSERT_TRUE(eventually([&] { return server.log().find("generation ") != std::string::npos; }))
        << server.log();
    server.finish(SIGKILL);
    arguments = resume_arguments();
  }
  Process server("evograsp-server", arguments, log("third"));
  EXPECT_EQ(server.finish(), 0) << server.log();
  const End expected = undisturbed_run("MAP_ELITES", 2);
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(expected.champion));
  expect_equal(map_in(run_dir()), expected.map);
}

TEST_F(Archives, EveryCellGivesAChampionThatSaysWhatItWasBredFor) {
  Process server("evograsp-server", server_arguments(settings("MAP_ELITES")), log("server"));
  auto worker = start_worker("worker", 2);
  ASSERT_EQ(server.finish(), 0) << server.log();
  auto reader = server::StoreReader::open(run_dir());
  ASSERT_TRUE(reader);
  const auto document = server::archive_json(**reader);
  ASSERT_TRUE(document);
  EXPECT_EQ((*document)["cells"], 20);
  EXPECT_EQ((*document)["x"]["measure"], "PITCH");
  const std::vector<EliteRecord> map = map_in(run_dir());
  ASSERT_EQ((*document)["elites"].size(), map.size());
  for (const EliteRecord& elite : map) {
    const auto bytes = server::elite_of(**reader, elite.x, elite.y);
    ASSERT_TRUE(bytes) << bytes.error().message;
    proto::Champion champion;
    ASSERT_TRUE(champion.ParseFromString(*bytes));
    EXPECT_EQ(champion.genome().id(), elite.genome);
    EXPECT_EQ(champion.network().outputs(), 7U);
    EXPECT_EQ(champion.fitness(), elite.fitness);
    EXPECT_FALSE(champion.fingerprint().empty());
    EXPECT_EQ(elite.cell, elite.x + 5 * elite.y);
    EXPECT_GE(elite.x_value, 0);
    EXPECT_LE(elite.x_value, 90);
  }
  EXPECT_EQ(server::elite_of(**reader, 63, 63).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace evograsp

#include "server/store.h"

#include <sqlite3.h>

#include <fstream>
#include <map>

#include "common/digest.h"
#include "server/store_schema.h"
#include "tests/server/store_fixture.h"

namespace evograsp::server {
namespace {

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Store, ANewRunIsReadBackAsItWasWritten) {
  RunFolder folder;
  const NewRun run = new_run();
  const auto store = Store::create(folder.path(), run);
  ASSERT_TRUE(store) << message(store);
  const auto reader = StoreReader::open(folder.path());
  ASSERT_TRUE(reader) << message(reader);
  const auto info = (*reader)->run();
  ASSERT_TRUE(info) << message(info);
  EXPECT_EQ(info->run_id, run.info.run_id);
  EXPECT_EQ(info->name, "cube");
  EXPECT_EQ(info->build, "test");
  EXPECT_GT(info->created_at, 1.6e9);
  EXPECT_EQ(deterministic_bytes(info->config), deterministic_bytes(run.info.config));
  EXPECT_EQ(deterministic_bytes(info->experiment), deterministic_bytes(run.info.experiment));
  const auto assets = (*reader)->assets();
  ASSERT_TRUE(assets && assets->size() == 2u);
  EXPECT_EQ((*assets)[0].packed, run.assets[0].packed);
  EXPECT_EQ((*assets)[1].kind, "hand");
  EXPECT_EQ((*reader)->population(0)->state, run.population);
  EXPECT_EQ((*reader)->progress()->epoch, 1u);
  EXPECT_FALSE((*reader)->last_generation()->has_value());
  EXPECT_EQ(*(*reader)->champion(), "");
}

TEST(Store, EveryRecordIsReadBackAsItWasWritten) {
  RunFolder folder;
  auto store = Store::create(folder.path(), new_run());
  ASSERT_TRUE(store) << message(store);
  ASSERT_TRUE(commit(**store, commit_of(0)));
  (*store)->note({0, 12.5, Severity::kWarning, "worker_lost", "n1 is silent"});
  (*store)->note({0, 0, Severity::kInfo, "worker_joined", "n2"});
  (*store)->saw_worker({"n1", "host", "0.1.0", "gone", 4, 1.0, 2.0, 5, 25});
  (*store)->keep_poison({0, 7, "killed 3 workers", "network", "trials"});
  (*store)->keep_validation({0, 1000, 40, 39, 0.875});
  proto::Champion champion;
  champion.set_run_seed(9);
  (*store)->keep_champion(champion, {});
  (*store)->set_state("finished");
  ASSERT_TRUE((*store)->flush());

  const auto reader = *StoreReader::open(folder.path());
  const auto generation = *reader->last_generation();
  ASSERT_TRUE(generation.has_value());
  EXPECT_EQ(generation->best, commit_of(0).record.best);
  EXPECT_EQ(generation->trials, 600u);
  EXPECT_EQ(generation->links, 311.5);
  EXPECT_GT(generation->committed_at, 1.6e9);
  const auto species = *reader->species(0);
  ASSERT_EQ(species.size(), 2u);
  EXPECT_EQ(species[1].size, 50u);
  EXPECT_EQ(species[1].best, 0.75);
  const auto events = *reader->events(0, 10);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].kind, "worker_lost");
  EXPECT_EQ(events[0].time, 12.5);
  EXPECT_EQ(events[0].severity, Severity::kWarning);
  EXPECT_GT(events[1].time, 1.6e9);
  EXPECT_EQ(reader->events(events[0].id, 10)->size(), 1u);
  EXPECT_EQ(reader->events(0, 1)->front().kind, "worker_joined");
  EXPECT_EQ(reader->workers()->front().trials, 25u);
  EXPECT_EQ(reader->poisons()->front().reason, "killed 3 workers");
  EXPECT_EQ(reader->validations()->front().successes, 39u);
  EXPECT_EQ(*reader->champion(), deterministic_bytes(champion));
  EXPECT_EQ(reader->progress()->state, "finished");
  EXPECT_EQ((*reader->best())->genome, 1000u);
}

TEST(Store, ResumingContinuesFromTheLastCommitWithTheJournalledWork) {
  RunFolder folder;
  {
    auto store = Store::create(folder.path(), new_run());
    ASSERT_TRUE(store) << message(store);
    for (std::uint32_t g = 0; g < 5; ++g) {
      for (std::uint64_t genome = 0; genome < 10; ++genome)
        (*store)->journal(evaluation_of(g, 10 * g + genome));
      (*store)->commit_generation(commit_of(g), {});
    }
    for (std::uint64_t genome = 53; genome >= 50; --genome) (*store)->journal(evaluation_of(5, genome));
    (*store)->keep_validation({4, 1004, 40, 20, 0.5});
  }
  auto resumed = Store::resume(folder.path());
  ASSERT_TRUE(resumed) << message(resumed);
  const ResumePoint& point = resumed->point;
  EXPECT_EQ(point.epoch, 2u);
  EXPECT_EQ(point.state, "running");
  EXPECT_EQ(point.generation, 5u);
  EXPECT_EQ(point.population, population_of(5));
  ASSERT_EQ(point.evaluations.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(point.evaluations[i].genome, 50 + i);
    EXPECT_EQ(point.evaluations[i].measurements, evaluation_of(5, 50 + i).measurements);
  }
  ASSERT_EQ(point.history.size(), 5u);
  EXPECT_EQ(point.history[3].mean, commit_of(3).record.mean);
  ASSERT_EQ(point.bests.size(), 3u);  // champion.candidates
  EXPECT_EQ(point.bests[0].generation, 2u);
  EXPECT_EQ(point.validations.size(), 1u);
  EXPECT_EQ(point.assets.size(), 2u);
  EXPECT_TRUE(point.warnings.empty());
}

TEST(Store, EveryStartCountsAnEpoch) {
  RunFolder folder;
  { ASSERT_TRUE(Store::create(folder.path(), new_run())); }
  for (std::uint64_t epoch = 2; epoch < 5; ++epoch)
    EXPECT_EQ(Store::resume(folder.path())->point.epoch, epoch);
}

TEST(Store, KeepsWhatRetentionSays) {
  const auto kept_after_ten = [](std::uint32_t keep_generations, bool journal_trials) {
    RunFolder folder;
    NewRun run = new_run();
    run.info.config.mutable_store()->set_keep_generations(keep_generations);
    run.info.config.mutable_store()->set_journal_trials(journal_trials);
    const auto store = *Store::create(folder.path(), run);
    for (std::uint32_t g = 0; g < 10; ++g) {
      store->journal(evaluation_of(g, g));
      store->commit_generation(commit_of(g), {});
    }
    EXPECT_TRUE(store->flush());
    const auto reader = *StoreReader::open(folder.path());
    std::size_t evaluations = 0;
    for (std::uint32_t g = 0; g < 10; ++g) evaluations += reader->evaluations(g)->size();
    EXPECT_EQ(reader->evaluations(9)->size(), 1u) << "the last judged generation can always be judged again";
    EXPECT_EQ(reader->generations(0, 100)->size(), 10u) << "statistics are never dropped";
    EXPECT_EQ(reader->bests(0, 100)->size(), 10u);
    EXPECT_EQ(reader->populations()->back(), 10u);
    return std::pair(reader->populations()->size(), evaluations);
  };
  EXPECT_EQ(kept_after_ten(0, false), std::pair(std::size_t{2}, std::size_t{1}));
  EXPECT_EQ(kept_after_ten(5, false), std::pair(std::size_t{5}, std::size_t{1}));
  EXPECT_EQ(kept_after_ten(0, true), std::pair(std::size_t{2}, std::size_t{10}));
}

TEST(Store, ForgetsTheWorkOfALiar) {
  RunFolder folder;
  const auto store = *Store::create(folder.path(), new_run());
  for (std::uint64_t genome = 0; genome < 6; ++genome) store->journal(evaluation_of(0, genome));
  store->forget_evaluations(0, "", {1, 3, 99});
  ASSERT_TRUE(store->flush());
  std::vector<std::uint64_t> left;
  const auto evaluations = (*StoreReader::open(folder.path()))->evaluations(0);
  for (const Evaluation& e : *evaluations) left.push_back(e.genome);
  EXPECT_EQ(left, (std::vector<std::uint64_t>{0, 2, 4, 5}));
}

TEST(Store, ACallbackComesAfterTheCommitCanBeRead) {
  RunFolder folder;
  const auto store = *Store::create(folder.path(), new_run());
  const auto reader = *StoreReader::open(folder.path());
  std::promise<std::size_t> seen;
  store->commit_generation(
      commit_of(0), [&](const Status& s) { seen.set_value(s ? reader->generations(0, 10)->size() : 0); });
  EXPECT_EQ(seen.get_future().get(), 1u);
}

std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

TEST(Store, ARunThatHasEndedIsOneFileWhoeverReadsIt) {
  const std::vector<std::string> kOne = {"run.db", "run.lock"};
  RunFolder folder;
  {
    const auto store = *Store::create(folder.path(), new_run());
    ASSERT_TRUE(commit(*store, commit_of(0)));
  }
  EXPECT_EQ(names_in(folder.path()), kOne);
  ASSERT_TRUE((*StoreReader::open(folder.path()))->run());
  EXPECT_EQ(names_in(folder.path()), kOne) << "a reader left something";
  // Taken up again, with a reader that stays: nothing is lost, and the next one that ends alone tidies up.
  std::unique_ptr<StoreReader> reader = *StoreReader::open(folder.path());
  {
    const auto store = std::move(Store::resume(folder.path())->store);
    ASSERT_TRUE(commit(*store, commit_of(1)));
    EXPECT_EQ((*reader->generations(0, 9)).size(), 2u) << "a reader of before does not see the commit";
  }
  EXPECT_EQ((*reader->generations(0, 9)).size(), 2u);
  reader.reset();
  EXPECT_EQ(Store::resume(folder.path())->point.generation, 2u);
  EXPECT_EQ(names_in(folder.path()), kOne);
}

TEST(Store, TheSchemaIsTheOneInTheGoldenFile) {
  EXPECT_EQ(std::string(schema_sql()), read_file(EVOGRASP_SOURCE_DIR "/tests/golden/store_schema.sql"))
      << "a changed schema needs a new kSchemaVersion, docs/STORE.md and a new golden file";
}

TEST(Store, TheExampleQueriesOfTheManualRun) {
  RunFolder folder;
  const auto store = *Store::create(folder.path(), new_run());
  ASSERT_TRUE(commit(*store, commit_of(0)));
  const std::string manual = read_file(EVOGRASP_SOURCE_DIR "/docs/STORE.md");
  auto database = *Database::open(folder.file(), Database::Mode::kReadOnly);
  int queries = 0;
  for (std::size_t at = manual.find("```sql\n"); at != std::string::npos;
       at = manual.find("```sql\n", at + 1)) {
    const std::string sql = manual.substr(at + 7, manual.find("```", at + 7) - at - 7);
    auto statement = database->prepare(sql);
    ASSERT_TRUE(statement) << sql << message(statement);
    EXPECT_TRUE(statement->step()) << sql;
    ++queries;
  }
  EXPECT_GE(queries, 5);
}

TEST(Measurements, PackAsTheSchemaSerialisesThem) {
  std::vector<proto::Measurement> several(3);
  several[1].set_quality(0.25);
  for (int i = 0; i < 3; ++i) several[2].mutable_p()->set_x(i);
  proto::Measurements message;
  for (const auto& m : several) *message.add_measurement() = m;
  const std::string packed = pack_measurements(several);
  EXPECT_EQ(packed, message.SerializeAsString());
  const auto back = unpack_measurements(packed);
  ASSERT_TRUE(back && back->size() == 3u);
  EXPECT_EQ((*back)[1].quality(), 0.25);
  EXPECT_FALSE(unpack_measurements("\x0a\xff"));
}

}  // namespace
}  // namespace evograsp::server

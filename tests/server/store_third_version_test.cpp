// What version 3 of run.db added: the map of grasps, the journal of optional trials, and how older files get
// them.
#include <gtest/gtest.h>

#include "server/store_schema.h"
#include "tests/server/older_run.h"
#include "tests/server/store_fixture.h"

namespace evograsp::server {
namespace {

EliteRecord elite_of_cell(std::uint32_t cell, double fitness, std::uint32_t updated) {
  EliteRecord e;
  e.cell = cell;
  e.x = cell % 5;
  e.y = cell / 5;
  e.x_value = 12.5 * cell;
  e.y_value = -0.01;
  e.fitness = fitness;
  e.judged = updated + 1;
  e.genome = 0xffffffffffffff00 + cell;
  e.generation = updated;
  e.updated = updated;
  e.genotype = genome_of(e.genome).SerializeAsString();
  e.network = "network " + std::to_string(cell);
  return e;
}

GenerationCommit with_elites(std::uint32_t generation, std::vector<EliteRecord> elites,
                             std::vector<std::uint32_t> emptied = {}) {
  GenerationCommit commit = commit_of(generation);
  commit.elites = std::move(elites);
  commit.emptied = std::move(emptied);
  return commit;
}

std::vector<std::pair<std::uint32_t, double>> map_of(const RunFolder& folder) {
  std::vector<std::pair<std::uint32_t, double>> cells;
  const auto elites = (*StoreReader::open(folder.path()))->elites();
  EXPECT_TRUE(elites) << message(elites);
  for (const EliteRecord& e : *elites) cells.emplace_back(e.cell, e.fitness);
  return cells;
}

Evaluation optional_of(std::uint32_t generation, std::uint64_t genome, const std::string& stage) {
  Evaluation e = evaluation_of(generation, genome);
  e.stage = stage;
  return e;
}

using Cells = std::vector<std::pair<std::uint32_t, double>>;

TEST(StoredMap, CellsAreReplacedAndEmptiedWithTheGeneration) {
  RunFolder folder;
  const auto store = *Store::create(folder.path(), new_run());
  ASSERT_TRUE(commit(*store, with_elites(0, {elite_of_cell(3, 0.5, 0), elite_of_cell(7, 0.25, 0)})));
  EXPECT_EQ(map_of(folder), (Cells{{3, 0.5}, {7, 0.25}}));
  ASSERT_TRUE(commit(*store, with_elites(1, {elite_of_cell(3, 0.75, 1)}, {7, 9})));
  EXPECT_EQ(map_of(folder), (Cells{{3, 0.75}}));
  const EliteRecord e = (*StoreReader::open(folder.path()))->elites()->at(0),
                    wanted = elite_of_cell(3, 0.75, 1);
  EXPECT_EQ(std::tie(e.x, e.y, e.x_value, e.y_value, e.judged, e.genome, e.generation, e.updated, e.genotype,
                     e.network),
            std::tie(wanted.x, wanted.y, wanted.x_value, wanted.y_value, wanted.judged, wanted.genome,
                     wanted.generation, wanted.updated, wanted.genotype, wanted.network));
}

// Of generations that share a transaction not all populations are written; of the map every change is.
TEST(StoredMap, GenerationsInOneTransactionLoseNoCell) {
  RunFolder folder;
  {
    const auto store = *Store::create(folder.path(), new_run());
    for (std::uint32_t g = 0; g < 6; ++g)
      store->commit_generation(with_elites(g, {elite_of_cell(g, 0.1, g)}), [](const Status&) {});
    ASSERT_TRUE(store->flush());
  }
  EXPECT_EQ(map_of(folder).size(), 6U);
}

TEST(StoredMap, FallingBackDropsWhatLaterGenerationsBrought) {
  RunFolder folder;
  {
    const auto store = *Store::create(folder.path(), new_run());
    for (std::uint32_t g = 0; g < 3; ++g)
      ASSERT_TRUE(commit(*store, with_elites(g, {elite_of_cell(g, 0.1, g)})));
  }
  {
    auto database = *Database::open(folder.file(), Database::Mode::kReadWrite);
    ASSERT_TRUE(database->exec("UPDATE populations SET state = x'00' WHERE generation = 3"));
  }
  const auto resumed = Store::resume(folder.path());
  ASSERT_TRUE(resumed) << message(resumed);
  EXPECT_EQ(resumed->point.generation, 2U);
  EXPECT_EQ(map_of(folder), (Cells{{0, 0.1}, {1, 0.1}}));
}

TEST(OptionalJournal, ComesBackByStageAndIsPrunedWithItsGeneration) {
  RunFolder folder;
  {
    const auto store = *Store::create(folder.path(), new_run());
    store->journal(optional_of(0, 5, "race 1"));
    ASSERT_TRUE(commit(*store, commit_of(0)));
    store->journal(evaluation_of(1, 5));
    store->journal(optional_of(1, 5, "race 1"));
    store->journal(optional_of(1, 6, "race 1"));
    store->journal(optional_of(1, 5, "lift"));
    store->forget_evaluations(1, "race 1", {6});
    store->keep_race(1, 3);
    ASSERT_TRUE(store->flush());
  }
  {
    const auto resumed = Store::resume(folder.path());
    ASSERT_TRUE(resumed) << message(resumed);
    const std::vector<Evaluation>& optional = resumed->point.optional;
    ASSERT_EQ(optional.size(), 2U);
    EXPECT_EQ(optional[0].stage, "lift");
    EXPECT_EQ(optional[1].stage, "race 1");
    EXPECT_EQ(optional[1].genome, 5U);
    EXPECT_EQ(optional[1].measurements, evaluation_of(1, 5).measurements);
    EXPECT_EQ(resumed->point.evaluations.size(), 1U);
    EXPECT_EQ(resumed->point.rounds, std::optional<std::uint32_t>(3));
    ASSERT_TRUE(commit(*resumed->store, commit_of(1)));
    ASSERT_TRUE(commit(*resumed->store, commit_of(2)));
  }
  const auto reader = *StoreReader::open(folder.path());
  EXPECT_TRUE(reader->optional_evaluations(0)->empty());
  EXPECT_TRUE(reader->optional_evaluations(1)->empty());
  EXPECT_EQ(*reader->race_rounds(1), std::optional<std::uint32_t>(3)) << "kept: it decided what came after";
  EXPECT_EQ(*reader->race_rounds(0), std::nullopt);
}

TEST(OptionalJournal, ADamagedRowCostsTheWorkNotTheRun) {
  RunFolder folder;
  {
    const auto store = *Store::create(folder.path(), new_run());
    store->journal(optional_of(0, 5, "lift"));
    store->journal(evaluation_of(0, 5));
    ASSERT_TRUE(store->flush());
  }
  {
    auto database = *Database::open(folder.file(), Database::Mode::kReadWrite);
    ASSERT_TRUE(database->exec("UPDATE optional_evaluations SET genome = 6"));
  }
  const auto resumed = Store::resume(folder.path());
  ASSERT_TRUE(resumed) << message(resumed);
  EXPECT_TRUE(resumed->point.optional.empty());
  EXPECT_EQ(resumed->point.warnings.size(), 1U);
}

TEST(OlderRuns, OfVersionTwoAreReadAsTheyAre) {
  RunFolder folder;
  {
    const auto store = *Store::create(folder.path(), new_run());
    ASSERT_TRUE(commit(*store, commit_of(0)));
  }
  ASSERT_EQ(make_second_version(folder.path()), "");
  const auto reader = StoreReader::open(folder.path());
  ASSERT_TRUE(reader) << message(reader);
  EXPECT_EQ((*reader)->generations(0, 10)->size(), 1U);
  EXPECT_TRUE((*reader)->elites()->empty());
  EXPECT_TRUE((*reader)->optional_evaluations(1)->empty());
  EXPECT_EQ(*(*reader)->race_rounds(1), std::nullopt);
}

TEST(OlderRuns, OfVersionTwoAreTakenUpAndBecomeOfVersionThree) {
  RunFolder folder;
  {
    const auto store = *Store::create(folder.path(), new_run());
    ASSERT_TRUE(commit(*store, commit_of(0)));
    store->journal(evaluation_of(1, 7));
    ASSERT_TRUE(store->flush());
  }
  ASSERT_EQ(make_second_version(folder.path()), "");
  {
    const auto resumed = Store::resume(folder.path());
    ASSERT_TRUE(resumed) << message(resumed);
    EXPECT_TRUE(right(resumed->point));
    EXPECT_EQ(resumed->point.evaluations.size(), 1U);
    resumed->store->journal(optional_of(1, 7, "lift"));
    ASSERT_TRUE(commit(*resumed->store, with_elites(1, {elite_of_cell(2, 0.5, 1)})));
  }
  EXPECT_EQ(map_of(folder), (Cells{{2, 0.5}}));
  const auto tables = [](const RunFolder& of) {
    auto database = *Database::open(of.file(), Database::Mode::kReadOnly);
    return *database->text(
               "SELECT group_concat(sql, char(10)) FROM (SELECT sql FROM sqlite_schema WHERE sql IS "
               "NOT NULL ORDER BY name)") +
           std::to_string(*database->integer("PRAGMA user_version"));
  };
  RunFolder fresh;
  { ASSERT_TRUE(Store::create(fresh.path(), new_run())); }
  EXPECT_EQ(tables(folder), tables(fresh));
}

}  // namespace
}  // namespace evograsp::server

// Breaking run.db for real: kills and flipped bits.
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <thread>

#include "common/digest.h"
#include "server/store_sqlite.h"
#include "tests/server/store_fixture.h"

namespace evograsp::server {
namespace {

namespace fs = std::filesystem;

// ---- kill -9 ----

// What a child has been promised, told as it happens through a pipe.
struct Promise {
  char kind;  // 'c' a generation is committed, 'j' genomes below `genome` of the generation are flushed
  std::uint32_t generation;
  std::uint64_t genome;
};

// Goes on with the run for ever.
[[noreturn]] void work_until_killed(const fs::path& run_dir, int promises) {
  const auto tell = [promises](Promise p) {
    if (::write(promises, &p, sizeof p) != sizeof p) ::_exit(2);
  };
  auto resumed = Store::resume(run_dir);
  if (!resumed || !right(resumed->point)) ::_exit(1);
  for (std::uint32_t g = resumed->point.generation;; ++g) {
    for (std::uint64_t genome = 0; genome < 40; ++genome) {
      resumed->store->journal(evaluation_of(g, genome));
      if (genome % 16 == 15) {
        if (!resumed->store->flush()) ::_exit(3);
        tell({'j', g, genome + 1});
      }
    }
    resumed->store->commit_generation(commit_of(g), [&tell, g](const Status& s) {
      if (s) tell({'c', g, 0});
    });
  }
}

TEST(StoreFault, KillAtAnyInstantLosesNothingThatWasPromised) {
  RunFolder folder;
  { ASSERT_TRUE(Store::create(folder.path(), new_run())); }
  Random random(42, Purpose::kTestHarness);
  std::uint32_t committed = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(8);
  int kills = 0;
  for (; kills < 60 && std::chrono::steady_clock::now() < end; ++kills) {
    int pipe[2];
    ASSERT_EQ(::pipe(pipe), 0);
    const pid_t child = ::fork();
    if (child == 0) work_until_killed(folder.path(), pipe[1]);
    ::close(pipe[1]);
    std::this_thread::sleep_for(std::chrono::microseconds(1000 + random.below(60000)));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child gave up with code " << WEXITSTATUS(status);
    Promise promise{}, flushed{};
    while (::read(pipe[0], &promise, sizeof promise) == sizeof promise) {
      if (promise.kind == 'c') committed = std::max(committed, promise.generation + 1);
      if (promise.kind == 'j') flushed = promise;
    }
    ::close(pipe[0]);

    auto resumed = Store::resume(folder.path());
    ASSERT_TRUE(resumed) << message(resumed);
    ASSERT_TRUE(right(resumed->point));
    ASSERT_TRUE(resumed->point.warnings.empty()) << resumed->point.warnings.front();
    ASSERT_GE(resumed->point.generation, committed) << "a committed generation is gone";
    committed = resumed->point.generation;
    if (flushed.kind == 'j' && flushed.generation == resumed->point.generation) {
      ASSERT_GE(resumed->point.evaluations.size(), flushed.genome) << "flushed work is gone";
    }
  }
  std::printf("%d kills, %u generations\n", kills, committed);
  EXPECT_GE(kills, 10);
  EXPECT_GT(committed, 0u);
}

// ---- flipped bits ----

// A run of five generations, each committed by itself, and some of the sixth, whole in run.db or still in its
// log.
void make_run(const fs::path& run_dir, const fs::path& copy_with_log) {
  const auto store = *Store::create(run_dir, new_run());
  for (std::uint32_t g = 0; g < 5; ++g) {
    for (std::uint64_t genome = 0; genome < 20; ++genome) store->journal(evaluation_of(g, genome));
    ASSERT_TRUE(commit(*store, commit_of(g)));
  }
  for (std::uint64_t genome = 0; genome < 10; ++genome) store->journal(evaluation_of(5, genome));
  ASSERT_TRUE(store->flush());
  fs::create_directories(copy_with_log);
  for (const char* file : {"run.db", "run.db-wal"}) fs::copy_file(run_dir / file, copy_with_log / file);
}

void flip(const fs::path& file, std::uint64_t bit) {
  std::fstream f(file, std::ios::in | std::ios::out | std::ios::binary);
  f.seekg(static_cast<std::streamoff>(bit / 8));
  const char byte = static_cast<char>(f.get() ^ (1 << (bit % 8)));
  f.seekp(static_cast<std::streamoff>(bit / 8));
  f.put(byte);
}

struct Verdicts {
  int whole = 0, earlier = 0, refused = 0;
};

void flip_everywhere(const fs::path& from, const char* file, int times, Verdicts& verdicts) {
  Random random(7, Purpose::kTestHarness);
  const std::uint64_t bits = 8 * fs::file_size(from / file);
  for (int i = 0; i < times; ++i) {
    RunFolder folder;
    for (const auto& entry : fs::directory_iterator(from)) fs::copy(entry.path(), folder.path());
    const std::uint64_t bit = random.next() % bits;
    flip(folder.path() / file, bit);
    auto resumed = Store::resume(folder.path());
    if (!resumed) {
      ++verdicts.refused;
      ASSERT_FALSE(resumed.error().message.empty());
      ASSERT_NE(resumed.error().message.find("run.db"), std::string::npos) << resumed.error().message;
      continue;
    }
    ASSERT_TRUE(right(resumed->point)) << file << " bit " << bit;
    (resumed->point.generation == 5 ? verdicts.whole : verdicts.earlier)++;
    // And the run can go on from there.
    ASSERT_TRUE(commit(*resumed->store, commit_of(resumed->point.generation))) << file << " bit " << bit;
  }
}

TEST(StoreFault, AFlippedBitIsNeverTakenForTruth) {
  RunFolder folder, logged;
  make_run(folder.path(), logged.path());
  Verdicts in_file, in_log;
  flip_everywhere(folder.path(), "run.db", 250, in_file);
  flip_everywhere(logged.path(), "run.db-wal", 100, in_log);
  std::printf("run.db: %d whole, %d earlier, %d refused; log: %d whole, %d earlier, %d refused\n",
              in_file.whole, in_file.earlier, in_file.refused, in_log.whole, in_log.earlier, in_log.refused);
  EXPECT_GT(in_file.earlier, 0) << "no flip hit the newest population";
  EXPECT_GT(in_log.earlier, 0);
}

TEST(StoreFault, ADamagedPopulationFallsBackToTheOneBeforeAndGoesOn) {
  RunFolder folder, logged;
  make_run(folder.path(), logged.path());
  {
    auto database = *Database::open(folder.file(), Database::Mode::kReadWrite);
    ASSERT_TRUE(database->exec("UPDATE populations SET state = x'00' WHERE generation = 5"));
  }
  {
    auto resumed = Store::resume(folder.path());
    ASSERT_TRUE(resumed) << message(resumed);
    EXPECT_EQ(resumed->point.generation, 4u);
    EXPECT_TRUE(right(resumed->point));
    EXPECT_EQ(resumed->point.evaluations.size(), 20u)
        << "the last judged generation need not be evaluated again";
    ASSERT_EQ(resumed->point.warnings.size(), 1u);
    EXPECT_NE(resumed->point.warnings[0].find("generation 5"), std::string::npos);
    ASSERT_TRUE(commit(*resumed->store, commit_of(4)));
  }
  auto again = Store::resume(folder.path());
  ASSERT_TRUE(again) << message(again);
  EXPECT_EQ(again->point.generation, 5u);
  EXPECT_TRUE(right(again->point));
  EXPECT_TRUE(again->point.warnings.empty());
}

// Generations that follow each other at once share transactions: what is kept of them is consistent all the
// same.
TEST(StoreFault, ADamagedPopulationOfGenerationsCommittedTogetherFallsBackFurther) {
  constexpr std::uint32_t kGenerations = 20;
  RunFolder folder;
  {
    NewRun run = new_run();
    run.info.config.mutable_store()->set_journal_seconds(0.2);
    const auto store = *Store::create(folder.path(), run);
    std::vector<std::uint32_t> told;  // on the store's thread, until flush() has returned
    for (std::uint32_t g = 0; g < kGenerations; ++g) {
      store->journal(evaluation_of(g, g));
      store->commit_generation(commit_of(g), [&told, g](const Status& s) {
        if (s) told.push_back(g);
      });
    }
    ASSERT_TRUE(store->flush());
    ASSERT_EQ(told.size(), kGenerations);
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_LT(store->figures().transactions, kGenerations) << "nothing was committed together";
  }
  std::uint32_t older = 0;
  {
    const auto kept = *(*StoreReader::open(folder.path()))->populations();
    ASSERT_EQ(kept.size(), 2u);
    ASSERT_EQ(kept.back(), kGenerations);
    older = kept.front();
    auto database = *Database::open(folder.file(), Database::Mode::kReadWrite);
    ASSERT_TRUE(database->exec("UPDATE populations SET state = x'00' WHERE generation = " +
                               std::to_string(kGenerations)));
  }
  auto resumed = Store::resume(folder.path());
  ASSERT_TRUE(resumed) << message(resumed);
  EXPECT_EQ(resumed->point.generation, older);
  EXPECT_EQ(resumed->point.history.size(), older);
  EXPECT_EQ(resumed->point.population, population_of(older));
  EXPECT_TRUE(commit(*resumed->store, commit_of(older)));
}

TEST(StoreFault, DamagedJournalledWorkIsDoneAgain) {
  RunFolder folder, logged;
  make_run(folder.path(), logged.path());
  {
    auto database = *Database::open(folder.file(), Database::Mode::kReadWrite);
    ASSERT_TRUE(
        database->exec("UPDATE evaluations SET measurements = x'0a00' WHERE generation = 5 AND genome = 3"));
  }
  auto resumed = Store::resume(folder.path());
  ASSERT_TRUE(resumed) << message(resumed);
  EXPECT_EQ(resumed->point.generation, 5u);
  EXPECT_TRUE(resumed->point.evaluations.empty());
  EXPECT_EQ(resumed->point.warnings.size(), 1u);
  EXPECT_TRUE(right(resumed->point));
}
}  // namespace
}  // namespace evograsp::server

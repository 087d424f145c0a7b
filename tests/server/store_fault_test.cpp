// Breaking run.db for real: kills, full and read-only disks, flipped bits, strangers' files.
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <thread>

#include "common/digest.h"
#include "server/store_schema.h"
#include "server/store_sqlite.h"
#include "tests/server/store_fixture.h"

namespace evograsp::server {
namespace {

namespace fs = std::filesystem;

// Whether everything that a resumed run leans on is exactly what was written.
testing::AssertionResult right(const ResumePoint& point) {
  const auto wrong = [](const std::string& what) {
    return testing::AssertionFailure() << what << " is not what was written";
  };
  if (point.population != population_of(point.generation))
    return wrong("population " + std::to_string(point.generation));
  if (deterministic_bytes(point.info.config) != deterministic_bytes(new_run().info.config))
    return wrong("config");
  if (point.info.run_id != new_run().info.run_id) return wrong("run id");
  if (point.assets.size() != 2 || point.assets[0].packed != new_run().assets[0].packed)
    return wrong("assets");
  for (const Evaluation& e : point.evaluations)
    if (e.generation != point.generation ||
        e.measurements != evaluation_of(e.generation, e.genome).measurements)
      return wrong("evaluation of genome " + std::to_string(e.genome));
  if (point.history.size() != point.generation) return wrong("length of the history");
  for (const GenerationRecord& g : point.history)
    if (g.best != commit_of(g.generation).record.best || g.seconds != commit_of(g.generation).record.seconds)
      return wrong("record of generation " + std::to_string(g.generation));
  for (const BestRecord& b : point.bests)
    if (b.genotype != commit_of(b.generation).best.genotype || b.genome != 1000 + b.generation)
      return wrong("best");
  return testing::AssertionSuccess();
}

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

// A run of five generations and some of the sixth, whole in run.db or still in its log.
void make_run(const fs::path& run_dir, const fs::path& copy_with_log) {
  const auto store = *Store::create(run_dir, new_run());
  for (std::uint32_t g = 0; g < 5; ++g) {
    for (std::uint64_t genome = 0; genome < 20; ++genome) store->journal(evaluation_of(g, genome));
    store->commit_generation(commit_of(g), {});
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

// ---- disks that say no ----

// A small file system in memory; absent where mounting is not allowed.
class SmallDisk {
 public:
  SmallDisk() {
    mounted_ = ::mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, "size=600k") == 0;
    if (!mounted_) std::printf("mounting is not allowed here: nothing tried on a small disk\n");
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(folder_.path().c_str(), MNT_DETACH);
  }
  bool mounted() const { return mounted_; }
  bool remount(unsigned long flags, const char* options) {
    return ::mount("tmpfs", folder_.path().c_str(), "tmpfs", MS_REMOUNT | flags, options) == 0;
  }
  const fs::path& path() const { return folder_.path(); }

 private:
  RunFolder folder_;
  bool mounted_ = false;
};

// Commits until the disk is full; how many generations were promised.
std::uint32_t fill(Store& store, Status& last) {
  for (std::uint32_t g = 0; g < 1000; ++g) {
    GenerationCommit change = commit_of(g);
    change.best.network += random_bytes(g, 20000);  // kept for ever, unlike the populations
    last = commit(store, std::move(change));
    if (!last) return g;
  }
  return 1000;
}

TEST(StoreFault, AFullDiskStopsTheRunWithOneErrorAndLosesNothing) {
  SmallDisk disk;
  if (!disk.mounted()) return;
  std::uint32_t committed = 0;
  {
    const auto store = Store::create(disk.path(), new_run());
    ASSERT_TRUE(store) << message(store);
    Status failed;
    committed = fill(**store, failed);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::kIo);
    EXPECT_NE(failed.error().message.find("disk is full"), std::string::npos) << failed.error().message;
    // The error stays: nothing is written behind the caller's back once there is room again.
    ASSERT_TRUE(disk.remount(0, "size=16m"));
    EXPECT_FALSE(commit(**store, commit_of(committed)));
    (*store)->journal(evaluation_of(committed, 1));
    EXPECT_FALSE((*store)->flush());
    EXPECT_EQ((*store)->status().error().message, failed.error().message);
  }
  EXPECT_GT(committed, 2u);
  EXPECT_EQ((*StoreReader::open(disk.path()))->generations(0, 1000)->size(), committed)
      << "readable as it is";
  auto resumed = Store::resume(disk.path());
  ASSERT_TRUE(resumed) << message(resumed);
  EXPECT_EQ(resumed->point.generation, committed);
  EXPECT_TRUE(right(resumed->point));
  EXPECT_TRUE(commit(*resumed->store, commit_of(committed)));
}

TEST(StoreFault, AFileSizeLimitStopsTheRunWithOneError) {
  RunFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{600 * 1024, 600 * 1024};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const auto store = Store::create(folder.path(), new_run());
    if (!store) ::_exit(100);
    Status failed;
    const std::uint32_t committed = fill(**store, failed);
    ::_exit(failed || failed.error().code != ErrorCode::kIo || committed > 90 ? 101
                                                                              : static_cast<int>(committed));
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_LT(WEXITSTATUS(status), 100);
  auto resumed = Store::resume(folder.path());
  ASSERT_TRUE(resumed) << message(resumed);
  EXPECT_EQ(resumed->point.generation, static_cast<std::uint32_t>(WEXITSTATUS(status)));
  EXPECT_TRUE(right(resumed->point));
}

TEST(StoreFault, AReadOnlyDiskCanBeReadAndIsRefusedForWriting) {
  SmallDisk disk;
  if (!disk.mounted()) return;
  {
    const auto store = *Store::create(disk.path(), new_run());
    ASSERT_TRUE(commit(*store, commit_of(0)));
  }
  ASSERT_TRUE(disk.remount(MS_RDONLY, "size=600k"));
  const auto resumed = Store::resume(disk.path());
  ASSERT_FALSE(resumed);
  EXPECT_EQ(resumed.error().code, ErrorCode::kIo) << resumed.error().message;
  const auto reader = StoreReader::open(disk.path());
  ASSERT_TRUE(reader) << message(reader);
  EXPECT_EQ((*reader)->generations(0, 10)->size(), 1u);
  const auto created = Store::create(disk.path() / "new", new_run());
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error().code, ErrorCode::kIo) << created.error().message;
}

// ---- files that are not ours ----

TEST(StoreFault, OtherSchemasAreNamed) {
  for (const int version : {0, kSchemaVersion + 1}) {
    RunFolder folder;
    { ASSERT_TRUE(Store::create(folder.path(), new_run())); }
    {
      auto database = *Database::open(folder.file(), Database::Mode::kReadWrite);
      ASSERT_TRUE(database->exec("PRAGMA user_version = " + std::to_string(version)));
    }
    const auto resumed = Store::resume(folder.path());
    ASSERT_FALSE(resumed);
    EXPECT_EQ(resumed.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(resumed.error().message.find("schema " + std::to_string(version)), std::string::npos);
    EXPECT_EQ(StoreReader::open(folder.path()).error().code, ErrorCode::kUnsupported);
  }
}

TEST(StoreFault, FilesThatAreNoRunAreRefused) {
  RunFolder folder;
  EXPECT_EQ(Store::resume(folder.path()).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(StoreReader::open(folder.path()).error().code, ErrorCode::kNotFound);
  std::ofstream(folder.file()) << std::string(10000, 'x');
  EXPECT_EQ(Store::resume(folder.path()).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(StoreReader::open(folder.path()).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(Store::create(folder.path(), new_run()).error().code, ErrorCode::kInvalid);
  fs::remove(folder.file());
  { ASSERT_TRUE((*Database::open(folder.file(), Database::Mode::kCreate))->exec("CREATE TABLE t (x)")); }
  EXPECT_EQ(Store::resume(folder.path()).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(Store::create(folder.path(), new_run()).error().code, ErrorCode::kInvalid);
}

TEST(StoreFault, ARunKilledBeforeItBeganCanBeBegunAgain) {
  RunFolder folder;
  std::ofstream(folder.file()).flush();
  EXPECT_FALSE(Store::resume(folder.path()));
  const auto store = Store::create(folder.path(), new_run());
  EXPECT_TRUE(store) << message(store);
}

TEST(StoreFault, ASecondServerIsToldWhoHasTheRun) {
  RunFolder folder;
  auto store = *Store::create(folder.path(), new_run());
  const auto second = Store::resume(folder.path());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(second.error().message.find(std::to_string(::getpid())), std::string::npos)
      << second.error().message;
  EXPECT_EQ(Store::create(folder.path(), new_run()).error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(is_live(folder.path()));
  store.reset();
  EXPECT_FALSE(is_live(folder.path()));
  EXPECT_TRUE(Store::resume(folder.path()));
}

TEST(StoreFault, AnExistingRunIsNotOverwritten) {
  RunFolder folder;
  { ASSERT_TRUE(Store::create(folder.path(), new_run())); }
  const auto second = Store::create(folder.path(), new_run());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kInvalid);
  EXPECT_NE(second.error().message.find("--resume"), std::string::npos);
}

// ---- readers beside the writer ----

TEST(StoreFault, ReadersSeeWholeGenerationsAndDoNotHoldUpTheWriter) {
  RunFolder folder;
  const auto store = *Store::create(folder.path(), new_run());
  std::atomic<bool> done{false};
  std::vector<std::thread> readers;
  std::atomic<int> reads{0};
  for (int i = 0; i < 3; ++i)
    readers.emplace_back([&] {
      const auto reader = *StoreReader::open(folder.path());
      while (!done) {
        const auto last = reader->last_generation();
        ASSERT_TRUE(last) << message(last);
        if (!*last) continue;
        const auto species = reader->species((*last)->generation);
        ASSERT_TRUE(species) << message(species);
        ASSERT_EQ(species->size(), 2u);
        ++reads;
      }
    });
  for (std::uint32_t g = 0; g < 100; ++g) {
    for (std::uint64_t genome = 0; genome < 50; ++genome) store->journal(evaluation_of(g, genome));
    ASSERT_TRUE(commit(*store, commit_of(g)));
  }
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_GT(reads.load(), 0);
}

}  // namespace
}  // namespace evograsp::server

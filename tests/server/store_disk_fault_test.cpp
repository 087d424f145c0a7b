// Disks that are full or read-only, files that are not ours, and readers beside the writer.
#include <sys/resource.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "server/store_schema.h"
#include "server/store_sqlite.h"
#include "tests/server/small_disk.h"
#include "tests/server/store_fixture.h"

namespace evograsp::server {
namespace {

namespace fs = std::filesystem;

// ---- disks that say no ----

using testing::SmallDisk;

// Before there are threads: user namespaces are for processes of one thread.
const bool kMayMount = testing::own_mounts();

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
  RunFolder folder;
  SmallDisk disk(folder.path(), "600k");
  ASSERT_TRUE(disk.mounted() && kMayMount) << "CANNOT RUN HERE: needs the right to mount";
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
    ASSERT_TRUE(disk.grow("16m"));
    EXPECT_FALSE(commit(**store, commit_of(committed)));
    (*store)->journal(evaluation_of(committed, 1));
    EXPECT_FALSE((*store)->flush());
    EXPECT_EQ((*store)->status().error().message, failed.error().message);
  }
  EXPECT_GT(committed, 2u);
  {
    const auto reader = *StoreReader::open(disk.path());
    EXPECT_EQ(reader->generations(0, 1000)->size(), committed) << "readable as it is";
    EXPECT_EQ(reader->progress()->state, "failed") << "nobody would see that it does not run any more";
    const auto events = reader->events(0, 10);
    ASSERT_TRUE(events && !events->empty());
    EXPECT_EQ(events->back().severity, Severity::kError);
    EXPECT_NE(events->back().text.find("disk is full"), std::string::npos) << events->back().text;
  }
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
  RunFolder folder;
  SmallDisk disk(folder.path(), "600k");
  ASSERT_TRUE(disk.mounted() && kMayMount) << "CANNOT RUN HERE: needs the right to mount";
  {
    const auto store = *Store::create(disk.path(), new_run());
    ASSERT_TRUE(commit(*store, commit_of(0)));
  }
  ASSERT_TRUE(disk.make_read_only());
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
  for (const int version : {0, kOldestSchema - 1, kSchemaVersion + 1}) {
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

// Disks that are full, read-only or flip a byte, and files of an earlier version, under the real server: one
// clear error, then the same champion once the cause is gone.
#include <sstream>

#include "server/store_sqlite.h"
#include "tests/server/older_run.h"
#include "tests/server/real_run.h"
#include "tests/server/small_disk.h"

namespace evograsp {
namespace {

namespace fs = std::filesystem;
using server::Database;
using testing::eventually;
using testing::Process;
using testing::SmallDisk;

const bool kMayMount = testing::own_mounts();  // before there are threads

class RealDisk : public testing::RealRun {
 protected:
  void SetUp() override { worker_ = start_worker("worker", 2); }
  void expect_generations(const Process& server) {
    ASSERT_TRUE(eventually([&] { return server.log().find("generation 2:") != std::string::npos; }))
        << server.log();
  }
  // Until three generations are committed and the next has begun.
  void kill_on_the_way() {
    Process server("evograsp-server", server_arguments(), log("first"));
    expect_generations(server);
    server.finish(SIGKILL);
  }
  static void expect_one_line(Process& server, int code, const std::string& about) {
    EXPECT_EQ(server.finish(), code) << server.log();
    std::istringstream lines(server.log());
    int errors = 0;
    for (std::string line; std::getline(lines, line);)
      if (line.rfind("evograsp-server: ", 0) == 0) {
        ++errors;
        EXPECT_NE(line.find(about), std::string::npos) << line;
      }
    EXPECT_EQ(errors, 1) << server.log();
  }
  // Text of the server that took the run to its end.
  std::string expect_same_champion() {
    Process server("evograsp-server", resume_arguments(), log("last"));
    EXPECT_EQ(server.finish(), 0) << server.log();
    EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
    return server.log();
  }
  fs::path file() const { return run_dir() / server::kStoreFile; }
  // One bit in the middle of a column of one row, whose seal stays as it was: what a disk does.
  void flip(const std::string& table, const std::string& column, const std::string& row) {
    auto database = *Database::open(file(), Database::Mode::kReadWrite);
    std::string blob;
    {
      auto read = *database->prepare("SELECT " + column + " FROM " + table + " WHERE " + row);
      ASSERT_TRUE(*read.step()) << row;
      blob = read.blob();
    }
    ASSERT_FALSE(blob.empty());
    blob[blob.size() / 2] = static_cast<char>(blob[blob.size() / 2] ^ 0x10);
    auto write = *database->prepare("UPDATE " + table + " SET " + column + " = ? WHERE " + row);
    write.bind_blob(blob);
    ASSERT_TRUE(write.run());
  }
  std::unique_ptr<Process> worker_;
};

TEST_F(RealDisk, AFullOneIsOneErrorAndTheRunGoesOnWhenThereIsRoom) {
  fs::create_directories(run_dir());
  SmallDisk disk(run_dir(), "64m");
  ASSERT_TRUE(disk.mounted() && kMayMount) << "CANNOT RUN HERE: needs the right to mount";
  {
    Process server("evograsp-server", server_arguments(), log("first"));
    expect_generations(server);
    ASSERT_TRUE(disk.fill());
    expect_one_line(server, 5, "the disk is full; what was committed is safe: free space, then resume");
  }
  ASSERT_TRUE(disk.restore());
  expect_same_champion();
}

TEST_F(RealDisk, AReadOnlyOneIsOneErrorAndTheRunGoesOnWhenItCanBeWritten) {
  fs::create_directories(run_dir());
  SmallDisk disk(run_dir(), "64m");
  ASSERT_TRUE(disk.mounted() && kMayMount) << "CANNOT RUN HERE: needs the right to mount";
  kill_on_the_way();
  ASSERT_TRUE(disk.make_read_only());
  {
    Process server("evograsp-server", resume_arguments(), log("second"));
    expect_one_line(server, 5, "must be writable");
  }
  ASSERT_TRUE(disk.restore());
  expect_same_champion();
}

TEST_F(RealDisk, AFlippedByteOfThePopulationCostsAGenerationAndNotTheChampion) {
  kill_on_the_way();
  flip("populations", "state", "generation = (SELECT max(generation) FROM populations)");
  EXPECT_NE(expect_same_champion().find("falling back to the one before"), std::string::npos);
}

TEST_F(RealDisk, AFlippedByteOfAJournalledEvaluationIsDoneAgain) {
  const std::string now = "generation = (SELECT max(generation) FROM populations)";
  {
    Process server("evograsp-server", server_arguments(), log("first"));
    expect_generations(server);
    worker_ = start_faulty("slow", "sleep:0.6");  // somewhere in a generation for long enough
    ASSERT_TRUE(eventually([&] {
      const auto database = Database::open(file(), Database::Mode::kReadOnly);
      const std::int64_t done =
          database ? (*database)->integer("SELECT count(*) FROM evaluations WHERE " + now).value_or(0) : 0;
      return done > 0 && done <= 12;  // of 24: the generation does not end before the master does
    })) << server.log();
    server.finish(SIGKILL);
  }
  flip("evaluations", "measurements",
       now + " AND genome = (SELECT min(genome) FROM evaluations WHERE " + now + ")");
  worker_ = start_worker("another", 2);
  EXPECT_NE(expect_same_champion().find("are done again"), std::string::npos);
}

TEST_F(RealDisk, AFlippedByteOfTheConfigIsRefusedInOneLine) {
  kill_on_the_way();
  flip("run", "config", "id = 1");
  Process server("evograsp-server", resume_arguments(), log("second"));
  expect_one_line(server, 3, "run.db");
}

TEST_F(RealDisk, ARunOfVersionTwoIsTakenUpToTheSameChampion) {
  kill_on_the_way();
  ASSERT_EQ(server::make_second_version(run_dir()), "");
  expect_same_champion();
  auto database = *Database::open(file(), Database::Mode::kReadOnly);
  EXPECT_EQ(*database->integer("PRAGMA user_version"), 3);
}

}  // namespace
}  // namespace evograsp

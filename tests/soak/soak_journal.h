// What a run.db says was evaluated, and how often.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/digest.h"
#include "server/store.h"
#include "server/store_reader.h"
#include "server/store_sqlite.h"

namespace evograsp::soak {

// Digest of the measurements of each (generation, genome) in a run.db.
using Journal = std::map<std::pair<std::uint32_t, std::uint64_t>, std::string>;

// Nothing when the file cannot be read just now. damaged: generations that hold a damaged row are left out.
inline std::optional<Journal> read_journal(const std::filesystem::path& run_dir, std::uint32_t generations,
                                           bool damaged = false) {
  Journal journal;
  auto reader = server::StoreReader::open(run_dir);
  if (!reader) return std::nullopt;
  for (std::uint32_t generation = 0; generation < generations; ++generation) {
    const auto rows = (*reader)->evaluations(generation);
    if (!rows && damaged) continue;
    if (!rows) return std::nullopt;
    for (const server::Evaluation& row : *rows)
      journal[{generation, row.genome}] = sha256_hex(row.measurements);
  }
  return journal;
}

// Counts what enters and leaves the journal, inside run.db itself: an evaluation that is written over another
// one counts twice, in whichever life of the master. Works beside a living one.
class Tally {
 public:
  // From now on; what is there already counts once. False when the file cannot be written just now.
  static bool begin(const std::filesystem::path& run_dir) {
    return change(
        run_dir,
        "BEGIN IMMEDIATE;"
        "DROP TRIGGER IF EXISTS tally_in; DROP TRIGGER IF EXISTS tally_out; DROP TABLE IF EXISTS tally;"
        "CREATE TABLE tally (generation INTEGER, genome INTEGER, change INTEGER);"
        "INSERT INTO tally SELECT generation, genome, 1 FROM evaluations;"
        "CREATE TRIGGER tally_in AFTER INSERT ON evaluations BEGIN"
        "  INSERT INTO tally VALUES (new.generation, new.genome, 1); END;"
        "CREATE TRIGGER tally_out AFTER DELETE ON evaluations BEGIN"
        "  INSERT INTO tally VALUES (old.generation, old.genome, -1); END;"
        "COMMIT");
  }
  // Empty when each journalled evaluation came in once more than it was taken back, and others as often; else
  // what is wrong.
  static std::string verdict(const std::filesystem::path& run_dir) {
    const auto database =
        server::Database::open(run_dir / server::kStoreFile, server::Database::Mode::kReadOnly);
    if (!database) return "cannot be read: " + database.error().message;
    const auto wrong = (*database)->text(
        "SELECT 'genome ' || genome || ' of generation ' || generation || ' came ' || came || ' times, went "
        "' || "
        "went || ' times and is ' || CASE WHEN here THEN 'here' ELSE 'gone' END FROM"
        " (SELECT t.generation, t.genome, sum(t.change > 0) AS came, sum(t.change < 0) AS went,"
        "  EXISTS (SELECT 1 FROM evaluations e WHERE e.generation = t.generation AND e.genome = t.genome) AS "
        "here"
        "  FROM tally t GROUP BY t.generation, t.genome) WHERE came - went <> here LIMIT 1");
    if (!wrong) return "cannot be read: " + wrong.error().message;
    if (!wrong->empty()) return *wrong;
    const auto uncounted = (*database)->integer(
        "SELECT count(*) FROM (SELECT generation, genome FROM evaluations EXCEPT SELECT generation, genome "
        "FROM tally)");
    if (!uncounted) return "cannot be read: " + uncounted.error().message;
    return *uncounted == 0 ? "" : std::to_string(*uncounted) + " evaluations were never counted";
  }
  // Evaluations that ever came in.
  static std::uint64_t accepted(const std::filesystem::path& run_dir) {
    const auto database =
        server::Database::open(run_dir / server::kStoreFile, server::Database::Mode::kReadOnly);
    if (!database) return 0;
    return static_cast<std::uint64_t>(
        (*database)->integer("SELECT count(*) FROM tally WHERE change > 0").value_or(0));
  }

 private:
  static bool change(const std::filesystem::path& run_dir, const char* sql) {
    const auto database =
        server::Database::open(run_dir / server::kStoreFile, server::Database::Mode::kReadWrite);
    return database && (*database)->exec(sql);
  }
};

}  // namespace evograsp::soak

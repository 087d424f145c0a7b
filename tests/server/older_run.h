// Runs as an earlier version of run.db held them.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "server/store.h"
#include "server/store_schema.h"
#include "server/store_sqlite.h"

namespace evograsp::server {

// Puts in the place of run.db a file that the statements of version 2 made (tests/golden/store_schema_2.sql,
// as they were then), with the same rows; what version 2 knew nothing of stays behind. Empty, or what went
// wrong.
inline std::string make_second_version(const std::filesystem::path& run_dir) {
  namespace fs = std::filesystem;
  const fs::path newer = run_dir / kStoreFile, older = run_dir / "older.db";
  std::ifstream in(EVOGRASP_SOURCE_DIR "/tests/golden/store_schema_2.sql");
  std::ostringstream statements;
  statements << in.rdbuf();
  {
    auto database = Database::open(older, Database::Mode::kCreate);
    if (!database) return database.error().message;
    std::string sql = "PRAGMA page_size = 8192; PRAGMA journal_mode = WAL; " + statements.str() +
                      "; PRAGMA application_id = " + std::to_string(kApplicationId) +
                      "; PRAGMA user_version = 2; ATTACH '" + newer.string() + "' AS newer; ";
    for (const char* table : {"run", "progress", "assets", "generations", "species", "bests", "populations",
                              "evaluations", "poisons", "validations", "champion", "events", "workers"})
      sql += std::string("INSERT INTO main.") + table + " SELECT * FROM newer." + table + "; ";
    if (const Status done = (*database)->exec(sql); !done) return done.error().message;
  }
  for (const char* rest : {"-wal", "-shm"}) fs::remove(newer.string() + rest);
  fs::rename(older, newer);
  return "";
}

}  // namespace evograsp::server

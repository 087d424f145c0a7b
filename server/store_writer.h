// One connection to run.db that writes, and its transactions. One thread.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <system_error>
#include <utility>

#include "server/store_open.h"
#include "server/store_tables.h"

namespace evograsp::server {

// Everything the store's thread touches: one connection and its statements.
class StoreWriter {
 public:
  StoreWriter(OpenRun run, StoreTables tables) : run_(std::move(run)), tables_(std::move(tables)) {}

  Status put(const Evaluation& evaluation) {
    if (Status s = begin(); !s) return s;
    return tables_.put_evaluation(evaluation);
  }

  Status put(const std::function<Status(StoreTables&)>& change) {
    if (Status s = begin(); !s) return s;
    return change(tables_);
  }

  // Between transactions: whether the next ones wait for the disk.
  Status sync(bool full) {
    if (full == full_) return {};
    full_ = full;
    return run_.database->exec(full ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = NORMAL");
  }

  Status begin() {
    return run_.database->in_transaction() ? Status() : run_.database->exec("BEGIN IMMEDIATE");
  }
  Status end() {
    if (!run_.database->in_transaction()) return {};
    ++transactions_;
    return run_.database->exec("COMMIT");
  }
  void roll_back() {
    if (run_.database->in_transaction()) static_cast<void>(run_.database->exec("ROLLBACK"));
  }
  void last_word(const RunProgress& progress, const std::string& error, const Retention& retention) {
    Status done = begin();
    if (done) done = tables_.put_progress(progress);
    if (done) done = end();
    if (done) done = begin();
    if (done) done = tables_.put_event({0, 0, Severity::kError, "failed", error}, unix_time(), retention);
    if (done) done = end();
    if (!done) roll_back();
  }
  // The log back into the file, so that run.db alone can be copied, and the file out of WAL mode: who opens
  // it later to read, and may not write, would leave an empty log beside it. A reader in the way only leaves
  // both as they were.
  void fold() {
    static_cast<void>(run_.database->exec("PRAGMA synchronous = FULL; PRAGMA wal_checkpoint(TRUNCATE)"));
    static_cast<void>(run_.database->exec("PRAGMA busy_timeout = 0; PRAGMA journal_mode = DELETE"));
  }

  std::uint64_t transactions() const { return transactions_; }
  std::uint64_t file_bytes() const {
    std::error_code ignored;
    const auto size = std::filesystem::file_size(run_.database->file(), ignored);
    return ignored ? 0 : size;
  }

 private:
  OpenRun run_;
  StoreTables tables_;
  std::uint64_t transactions_ = 0;
  bool full_ = false;
};

}  // namespace evograsp::server

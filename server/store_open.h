// Opening a run for writing: making a new one, or finding the newest state that is whole.
#pragma once

#include <filesystem>
#include <memory>

#include "common/result.h"
#include "server/store.h"
#include "server/store_lock.h"
#include "server/store_sqlite.h"

namespace evograsp::server {

// A run held open for writing. Members close in reverse order: the file before its lock.
struct OpenRun {
  RunLock lock;
  std::unique_ptr<Database> database;
};

// False also for the empty file that a server leaves which is killed before its first commit.
bool holds_run(const std::filesystem::path& run_dir);
Result<OpenRun> open_new(const std::filesystem::path& run_dir, const NewRun& run);
// Checks the file, takes up its newest whole state and counts the start.
Result<OpenRun> open_existing(const std::filesystem::path& run_dir, ResumePoint& point);

}  // namespace evograsp::server

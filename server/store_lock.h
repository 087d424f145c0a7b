// One server a run: an advisory lock on run.lock beside run.db, released by the kernel when its holder dies.
#pragma once

#include <filesystem>

#include "common/result.h"

namespace evograsp::server {

class RunLock {
 public:
  // kUnavailable when another process has it, naming the process.
  static Result<RunLock> take(const std::filesystem::path& run_dir);
  RunLock(RunLock&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
  RunLock& operator=(RunLock&&) = delete;
  ~RunLock();

 private:
  explicit RunLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace evograsp::server

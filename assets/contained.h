// Work on untrusted input by libraries that may crash, hang or eat memory: done in a forked child with
// limits.
#pragma once

#include <functional>
#include <string>

#include "common/result.h"

namespace evograsp::assets {

struct Containment {
  double seconds = 20;                          // of CPU (rounded up); of wall time ten times that and 10 s
  std::size_t memory = std::size_t{2} << 30;    // beyond what the process has, bytes
  std::size_t answer = std::size_t{512} << 20;  // largest answer, bytes
};

// Runs `work` in a child process and returns its answer. An error says how the child failed ("took longer
// than 20 s", "crashed (signal 11)", the text of an exception) without naming a file. The child has no
// standard output, can write no files, and sees the memory of the parent as it was; it must not wait for
// other threads.
Result<std::string> run_contained(const std::function<Result<std::string>()>& work,
                                  const Containment& limits);

}  // namespace evograsp::assets

// A master without evolution in a process of its own: the server's real dispatcher, gathering and store, on
// work that simulates nothing.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/result.h"
#include "common/socket.h"

namespace evograsp::cli {

struct BenchMasterOptions {
  std::uint32_t evaluations = 1000;  // that wait at the start
  std::uint32_t trials = 1;          // of an evaluation, a task each
  std::size_t genome_bytes = 20000;
  std::uint32_t credit = 2;
  std::optional<CurveKeys> curve;  // the server's
  std::string allowed_key;         // with curve: the workers' public key
};

struct BenchMasterFigures {
  double seconds = 0;      // when the counters below stood so; they are a moment old
  double cpu_seconds = 0;  // user and system, all threads; of now
  std::uint64_t resident_bytes = 0;
  std::uint64_t evaluations = 0, lost_workers = 0, refused = 0, workers = 0;
  std::uint64_t tasks = 0;  // answered
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  std::uint64_t genome_bytes = 0, network_bytes = 0, packed_bytes = 0;  // cli/bench_genome.h
};

class BenchMaster {
 public:
  // Forks: call it before any thread is there.
  static Result<std::unique_ptr<BenchMaster>> start(const BenchMasterOptions& options);
  virtual ~BenchMaster() = default;  // ends the process
  virtual const std::string& endpoint() const = 0;
  virtual Status begin_work() = 0;
  virtual Result<BenchMasterFigures> figures() = 0;
};

}  // namespace evograsp::cli

// Many workers in one thread: real sockets and the real protocol, but work that only takes time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/result.h"
#include "common/socket.h"

namespace evograsp::cli {

enum class WorkTimes { kFixed, kUniform, kExponential };  // uniform: 0 to twice the mean

struct FakeWorkersOptions {
  std::string connect;
  int workers = 100, slots = 1;
  double mean_seconds = 0.005;  // of an evaluation
  WorkTimes times = WorkTimes::kFixed;
  std::optional<CurveKeys> curve;
};

// What was seen since the last reset().
struct FakeWorkersFigures {
  double seconds = 0;       // wall
  double busy_seconds = 0;  // of all slots
  std::uint64_t tasks = 0;  // answered
  double worst_late = 0;    // s that an answer left later than its work ended: this process is starved
};

// A slot that has its next task by the time it ends one begins it at that very moment, however late this
// process comes to look: what it shows as idle is the master's doing. Not thread-safe.
class FakeWorkers {
 public:
  static Result<std::unique_ptr<FakeWorkers>> create(const FakeWorkersOptions& options);
  virtual ~FakeWorkers() = default;
  // Serves for so long.
  virtual void serve(double seconds) = 0;
  virtual int ready() const = 0;  // workers that the master has welcomed
  virtual void reset() = 0;
  virtual FakeWorkersFigures figures() const = 0;
};

}  // namespace evograsp::cli

// How many slots a run could use: what an operator or an autoscaler wants to know.
#pragma once

#include <cstdint>

namespace evograsp::server {

// A generation ends when its last trial does, and the next one cannot begin before it has been bred: time
// that more slots do not shorten (Amdahl, "Validity of the single processor approach to achieving large scale
// computing capabilities", AFIPS 1967). With W slot-seconds of work a generation, B seconds between
// generations and a smallest task of u seconds, n slots are busy for the share (W / n) / (B + u + W / n) of
// the time. The hint is the n at which that is kBusyShare: n = W (1 - kBusyShare) / kBusyShare / (B + u), at
// least 1 and at most one slot a trial. Not thread-safe.
class SlotHint {
 public:
  static constexpr double kBusyShare = 0.8;

  // Work begins: `now` is monotonic, s; trials: networks x trials of it.
  void begin(double now, std::uint64_t trials);
  // All of it is done; it took slots `work_seconds`; smallest_task: s.
  void finish(double now, double work_seconds, double smallest_task);
  // 0: not known before the second generation.
  std::uint64_t slots() const;

 private:
  double finished_ = -1;  // when the last work was
  double between_ = -1, work_ = 0, smallest_ = 0;
  std::uint64_t trials_ = 0;
};

}  // namespace evograsp::server

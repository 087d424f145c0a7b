#include "server/slot_hint.h"

#include <algorithm>

namespace evograsp::server {

namespace {

constexpr double kLearningRate = 0.3;  // the last few generations count
constexpr double kLeastSeconds = 1e-6;

double learn(double known, double seen) {
  return known + kLearningRate * (seen - known);
}

}  // namespace

void SlotHint::begin(double now, std::uint64_t trials) {
  trials_ = trials;
  if (finished_ < 0) return;
  const double between = now - finished_;
  between_ = between_ < 0 ? between : learn(between_, between);
  finished_ = -1;
}

void SlotHint::finish(double now, double work_seconds, double smallest_task) {
  finished_ = now;
  work_ = work_ > 0 ? learn(work_, work_seconds) : work_seconds;
  smallest_ = smallest_task;
}

std::uint64_t SlotHint::slots() const {
  if (between_ < 0 || work_ <= 0) return 0;
  const double idle = std::max(kLeastSeconds, between_ + smallest_);
  const double wanted = work_ * (1 - kBusyShare) / kBusyShare / idle;
  return static_cast<std::uint64_t>(std::clamp(wanted, 1.0, std::max(1.0, static_cast<double>(trials_))));
}

}  // namespace evograsp::server

// One moment of the run after another, for everybody who looks.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/mutex.h"
#include "server/gather.h"
#include "server/run_control.h"
#include "server/run_loop.h"

namespace evograsp::server {

class Snapshots {
 public:
  Snapshots(const ResumePoint& start, const std::filesystem::path& run_dir);

  // Thread-safe; never null.
  std::shared_ptr<const RunSnapshot> last() const;

  // One thread at a time.
  void publish(RunState state, const RunPosition& position, const std::optional<proto::Champion>& champion,
               const DispatchView& dispatch, const Gather& gather, const StoreFigures& store);
  void set_error(std::string error) { base_.error = std::move(error); }

 private:
  void fill_workers(RunSnapshot& snapshot, const DispatchView& dispatch);
  void fill_rate(RunSnapshot& snapshot, const RunPosition& position, std::uint64_t trials);
  void fill_champion(RunSnapshot& snapshot, const RunPosition& position,
                     const std::optional<proto::Champion>& champion);

  const proto::Config config_;
  RunSnapshot base_;  // what does not change
  double last_time_ = 0;
  std::uint64_t last_trials_ = 0;
  double rate_ = 0;  // trials a second, smoothed
  std::shared_ptr<const std::string> best_;
  std::uint32_t best_generation_ = 0;
  bool chosen_ = false;

  mutable Mutex mutex_;
  std::shared_ptr<const RunSnapshot> last_ GUARDED_BY(mutex_);
};

}  // namespace evograsp::server

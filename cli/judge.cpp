#include "cli/judge.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "common/mutex.h"
#include "common/random.h"
#include "score/score.h"
#include "sim/lift.h"
#include "worker/evaluator.h"

namespace evograsp::cli {
namespace {

struct Attempt {
  bool success = false, lifted = false, unseen = false;
};

// One thread's share: a workspace and the buffers of the network.
class Judge {
 public:
  Judge(const Network& network, const sim::Simulator& simulator, int target, const JudgeOptions& options)
      : network_(network),
        simulator_(simulator),
        target_(target),
        options_(options),
        workspace_(simulator.make_workspace()),
        inputs_(static_cast<std::size_t>(simulator.inputs())),
        outputs_(sim::kOutputs) {}

  Result<Attempt> attempt(int index) {
    const auto seed = hash_key(options_.seed, Purpose::kTest, 0, static_cast<std::uint64_t>(index));
    const auto placements = simulator_.shuffle(seed);
    if (!placements) return tl::unexpected(placements.error());
    const auto info = simulator_.get_info(*placements, target_, 0, options_.bounding_box);
    Attempt result;
    result.unseen = !info.has_value();
    if (result.unseen) return result;
    info->write_inputs(inputs_);
    network_.activate(inputs_, outputs_, scratch_, kRecurrentSteps);
    const Pose tool = simulator_.decode(outputs_, *info, options_.bounding_box);
    sim::GraspReport attempt;
    const sim::Measurement measured =
        simulator_.get_quality(*placements, target_, tool, *workspace_, &attempt);
    result.success = score::success(worker::to_proto(measured));
    if (options_.lift && measured.contacts > 0) {
      const auto lift = sim::lift_test(simulator_, *placements, target_, attempt);
      if (!lift) return tl::unexpected(lift.error());
      result.lifted = lift->held;
    }
    return result;
  }

 private:
  const Network& network_;
  const sim::Simulator& simulator_;
  const int target_;
  const JudgeOptions& options_;
  std::unique_ptr<sim::Workspace> workspace_;
  std::vector<float> inputs_, outputs_;
  Network::Scratch scratch_;
};

}  // namespace

Result<Judgement> judge(const Network& network, const sim::Simulator& simulator, int target,
                        const JudgeOptions& options) {
  if (network.inputs() != simulator.inputs() || network.outputs() != sim::kOutputs) {
    return fail(ErrorCode::kInvalid, "the network has " + std::to_string(network.inputs()) +
                                         " inputs, the experiment gives " +
                                         std::to_string(simulator.inputs()));
  }
  std::vector<Attempt> attempts(static_cast<std::size_t>(options.placements));
  std::atomic<int> next{0};
  Mutex mutex;
  Status status;  // guarded by mutex
  const auto stopped = [&options] { return options.stop != nullptr && *options.stop; };
  const auto work = [&] {
    Judge judge(network, simulator, target, options);
    for (int i = next++; i < options.placements && !stopped(); i = next++) {
      const auto result = judge.attempt(i);
      if (result) {
        attempts[static_cast<std::size_t>(i)] = *result;
        continue;
      }
      const MutexLock lock(mutex);
      status = tl::unexpected(result.error());
      return;
    }
  };
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<std::thread> threads;
  for (int i = std::min(options.threads > 0 ? options.threads : cores, options.placements); i > 0; --i)
    threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  if (!status) return tl::unexpected(status.error());
  if (stopped()) return fail(ErrorCode::kUnavailable, "stopped");

  Judgement total;
  for (const Attempt& attempt : attempts) {
    ++total.n;
    total.successes += attempt.success ? 1 : 0;
    total.lifts += attempt.lifted ? 1 : 0;
    total.unseen += attempt.unseen ? 1 : 0;
  }
  return total;
}

Interval wilson(int successes, int n) {
  if (n <= 0) return {0, 1};
  constexpr double z = 1.959963984540054;
  const double p = static_cast<double>(successes) / n;
  const double scale = 1 + z * z / n;
  const double centre = (p + z * z / (2 * n)) / scale;
  const double half = z / scale * std::sqrt(p * (1 - p) / n + z * z / (4.0 * n * n));
  // Exact at the ends, where rounding would leave a bound beside 0 or 1.
  return {successes <= 0 ? 0 : std::max(0.0, centre - half),
          successes >= n ? 1 : std::min(1.0, centre + half)};
}

}  // namespace evograsp::cli

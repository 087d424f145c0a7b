// The lift test of a grasp that lasts to the end: the longest kind.
#include <benchmark/benchmark.h>

#include <cstdlib>

#include "sim/lift.h"
#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

struct Held {
  std::shared_ptr<const Simulator> simulator = testing::make_simulator({"cube_6cm"});
  testing::Trial trial;
  GraspReport attempt;
};

// The first random grasp of a 6 cm cube by the Meka hand that survives.
const Held& held_cube() {
  static const Held found = [] {
    Held held;
    const auto workspace = held.simulator->make_workspace();
    for (std::uint64_t index = 0;; ++index) {
      held.trial = testing::random_trial(*held.simulator, index);
      const auto measured = held.simulator->get_quality(held.trial.placements, held.trial.target,
                                                        held.trial.tool, *workspace, &held.attempt);
      if (measured.quality < 0.1) continue;
      const auto report = lift_test(*held.simulator, held.trial.placements, held.trial.target, held.attempt);
      if (report && report->held) return held;
    }
  }();
  return found;
}

void lift_cube(benchmark::State& state) {
  const Held& held = held_cube();
  double seconds = 0;
  for (auto _ : state) {
    const auto report = lift_test(*held.simulator, held.trial.placements, held.trial.target, held.attempt);
    if (!report || !report->held) std::abort();
    seconds = report->time;
  }
  state.counters["simulated_seconds"] = seconds;
}
BENCHMARK(lift_cube)->Name("lift/cube")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace evograsp::sim

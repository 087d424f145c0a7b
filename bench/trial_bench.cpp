// A whole grasp attempt on one core: approach, closing, contacts, quality.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

constexpr int kTrials = 2000;

struct Prepared {
  std::shared_ptr<const Simulator> sim;
  std::vector<testing::Trial> trial;
};

// The scene's random poses, all of them or those that end in force closure.
Prepared prepare(const std::vector<std::string>& objects, bool closed_only) {
  Prepared out{testing::make_simulator(objects), {}};
  const auto workspace = out.sim->make_workspace();
  for (std::uint64_t i = 0; static_cast<int>(out.trial.size()) < kTrials; ++i) {
    testing::Trial t = testing::random_trial(*out.sim, i);
    if (closed_only && !(out.sim->get_quality(t.placements, t.target, t.tool, *workspace).quality > 0))
      continue;
    out.trial.push_back(std::move(t));
  }
  return out;
}

// An iteration is one trial; the counters are quantiles over single trials, each at its fastest of three.
void run(benchmark::State& state, const std::vector<std::string>& objects, bool closed_only) {
  const Prepared p = prepare(objects, closed_only);
  const auto workspace = p.sim->make_workspace();
  using Clock = std::chrono::steady_clock;
  std::vector<double> fastest(p.trial.size(), 1e9);
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < p.trial.size(); ++i) {
      const testing::Trial& t = p.trial[i];
      const auto begin = Clock::now();
      benchmark::DoNotOptimize(p.sim->get_quality(t.placements, t.target, t.tool, *workspace));
      fastest[i] =
          std::min(fastest[i], std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    }
  }
  std::sort(fastest.begin(), fastest.end());
  std::size_t next = 0;
  for (auto _ : state) {
    const testing::Trial& t = p.trial[next];
    next = (next + 1) % p.trial.size();
    benchmark::DoNotOptimize(p.sim->get_quality(t.placements, t.target, t.tool, *workspace));
  }
  state.counters["median_us"] = fastest[fastest.size() / 2];
  state.counters["p95_us"] = fastest[fastest.size() * 95 / 100];
}

const std::vector<std::string> kAll = {"cylinder", "cube", "sphere", "mug"};

[[maybe_unused]] const auto* const kRandom =
    benchmark::RegisterBenchmark("trial/random", run, kAll, false) -> Unit(benchmark::kMicrosecond);
[[maybe_unused]] const auto* const kClosed =
    benchmark::RegisterBenchmark("trial/closed", run, kAll, true) -> Unit(benchmark::kMicrosecond);
[[maybe_unused]] const auto* const kCube =
    benchmark::RegisterBenchmark("trial/random_cube", run, std::vector<std::string>{"cube"}, false)
        -> Unit(benchmark::kMicrosecond);
[[maybe_unused]] const auto* const kMug =
    benchmark::RegisterBenchmark("trial/closed_mug", run, std::vector<std::string>{"mug"}, true)
        -> Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace evograsp::sim

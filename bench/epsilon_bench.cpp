// Epsilon of 8 contacts x 8 edges, ours and qhull's with the options that GraspIt! passes, on the same sets.
#include <benchmark/benchmark.h>

#include <vector>

#include "sim/quality.h"
#include "tests/sim/contact_sets.h"
#include "tests/sim/hull_oracle.h"

namespace evograsp::sim {
namespace {

// Force-closed sets of every kind in turn: open ones are answered at once, and would flatter.
const std::vector<std::vector<Wrench>>& sets() {
  static const auto all = [] {
    std::vector<std::vector<Wrench>> closed;
    Epsilon epsilon;
    for (int index = 0; closed.size() < 32; ++index) {
      auto wrenches = testing::draw_wrenches(testing::kKinds[index % 4], 8, index);
      if (epsilon(wrenches) > 1e-6) closed.push_back(std::move(wrenches));
    }
    return closed;
  }();
  return all;
}

void epsilon_ours(benchmark::State& state) {
  Epsilon epsilon;
  double sum = 0;
  std::size_t next = 0;
  for (const auto& set : sets()) sum += epsilon(set);  // warm
  for (auto _ : state) sum += epsilon(sets()[next++ % sets().size()]);
  benchmark::DoNotOptimize(sum);
}
BENCHMARK(epsilon_ours)->Name("epsilon/8");

void epsilon_qhull(benchmark::State& state) {
  double sum = 0;
  std::size_t next = 0;
  for (auto _ : state) {
    sum += testing::qhull_epsilon(sets()[next++ % sets().size()], testing::kGraspitOptions).value_or(0);
  }
  benchmark::DoNotOptimize(sum);
}
BENCHMARK(epsilon_qhull)->Name("epsilon_qhull/8")->Unit(benchmark::kMicrosecond);

// The same for a set that is not force-closed: what most random poses cost.
void epsilon_open(benchmark::State& state) {
  std::vector<std::vector<Wrench>> open;
  Epsilon epsilon;
  for (int index = 0; open.size() < 32; ++index) {
    auto wrenches = testing::draw_wrenches(testing::kKinds[index % 4], 4, index);
    if (epsilon(wrenches) == 0) open.push_back(std::move(wrenches));
  }
  double sum = 0;
  std::size_t next = 0;
  for (auto _ : state) sum += epsilon(open[next++ % open.size()]);
  benchmark::DoNotOptimize(sum);
}
BENCHMARK(epsilon_open)->Name("epsilon_open/4");

}  // namespace
}  // namespace evograsp::sim

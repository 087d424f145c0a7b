// One generation of NEAT, as a master spends it: tell(), then every phenotype built. Genomes of 304 inputs
// and 7 outputs; thesis parameters. neat/NxH: N genomes with H hidden nodes at the start.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include "common/random.h"
#include "neat/express.h"
#include "neat/population.h"

namespace {

using evograsp::Random;

double thread_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Generations 15 to 30 are timed (and their median reported beside); what comes before only makes them.
void generation(benchmark::State& state, std::uint32_t size, std::uint32_t hidden) {
  evograsp::proto::NeatConfig config;
  config.set_population(size);
  config.set_hidden(hidden);
  evograsp::neat::Expressor expressor(config);
  constexpr int kGenerations = 30;
  std::optional<evograsp::neat::Population> population;
  std::vector<double> seconds, tells, fitness(size);
  Random random(1, evograsp::Purpose::kTestHarness);
  const auto next = [&] {
    const double growth = 1 + 0.01 * population->generation();
    for (double& f : fitness) f = growth * random.uniform();
    const double begin = thread_seconds();
    population->tell(fitness);
    tells.push_back(thread_seconds() - begin);
    for (const auto& genome : population->ask()) benchmark::DoNotOptimize(expressor.express(genome));
    seconds.push_back(thread_seconds() - begin);
  };
  std::uint64_t seed = 0;
  for (auto _ : state) {
    state.PauseTiming();
    if (!population || population->generation() == kGenerations) {
      population = evograsp::neat::Population::create(config, 304, 7, ++seed).value();
      while (population->generation() < kGenerations / 2) next();
    }
    state.ResumeTiming();
    next();
  }
  double links = 0;
  for (const auto& genome : population->ask()) links += genome.links();
  state.counters["median_ms"] = median(seconds) * 1e3;
  state.counters["tell_ms"] = median(tells) * 1e3;
  state.counters["links"] = links / size;
  state.counters["species"] = static_cast<double>(population->species().size());
}

const bool registered = [] {
  for (const std::uint32_t size : {150u, 1000u, 10000u})
    for (const std::uint32_t hidden : {1u, 4u}) {
      const std::string name = "neat/" + std::to_string(size) + "x" + std::to_string(hidden);
      benchmark::RegisterBenchmark(name.c_str(), [=](auto& state) {
        generation(state, size, hidden);
      })->Unit(benchmark::kMillisecond);
    }
  return true;
}();

}  // namespace

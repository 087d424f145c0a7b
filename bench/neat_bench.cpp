// One generation of NEAT, as a master spends it: tell(), then every phenotype built. Genomes of 304 inputs
// and 7 outputs; thesis parameters. neat/NxH: N genomes with H hidden nodes at the start.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
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

constexpr std::uint32_t kGenerations = 30;

// A population that is bred with random fitness, and how long that takes.
class Breeder {
 public:
  Breeder(std::uint32_t size, std::uint32_t hidden) : fitness_(size) {
    config_.set_population(size);
    config_.set_hidden(hidden);
    expressor_.emplace(config_);
  }

  // A new population, bred up to the generations that are timed.
  void begin(std::uint64_t seed) {
    population_ = evograsp::neat::Population::create(config_, 304, 7, seed).value();
    while (population_->generation() < kGenerations / 2) next();
    seconds.clear();
    tells.clear();
  }
  bool done() const { return !population_ || population_->generation() == kGenerations; }
  void next() {
    const double growth = 1 + 0.01 * population_->generation();
    for (double& f : fitness_) f = growth * random_.uniform();
    const double begin = thread_seconds();
    population_->tell(fitness_);
    tells.push_back(thread_seconds() - begin);
    for (const auto& genome : population_->ask()) benchmark::DoNotOptimize(expressor_->express(genome));
    seconds.push_back(thread_seconds() - begin);
  }
  double links() const {  // of a genome, on average
    double sum = 0;
    for (const auto& genome : population_->ask()) sum += genome.links();
    return sum / static_cast<double>(fitness_.size());
  }
  const evograsp::neat::Population& population() const { return *population_; }

  std::vector<double> seconds, tells;  // of each generation since begin()

 private:
  evograsp::proto::NeatConfig config_;
  std::optional<evograsp::neat::Expressor> expressor_;
  std::optional<evograsp::neat::Population> population_;
  std::vector<double> fitness_;
  Random random_{1, evograsp::Purpose::kTestHarness};
};

// Generations 15 to 30 are timed (and their median reported beside); what comes before only makes them.
void generation(benchmark::State& state, std::uint32_t size, std::uint32_t hidden) {
  Breeder breeder(size, hidden);
  std::uint64_t seed = 0;
  std::vector<double> seconds, tells;
  for (auto _ : state) {
    if (breeder.done()) {
      state.PauseTiming();
      breeder.begin(++seed);
      state.ResumeTiming();
    }
    breeder.next();
    seconds.push_back(breeder.seconds.back());
    tells.push_back(breeder.tells.back());
  }
  state.counters["median_ms"] = median(seconds) * 1e3;
  state.counters["tell_ms"] = median(tells) * 1e3;
  state.counters["links"] = breeder.links();
  state.counters["species"] = static_cast<double>(breeder.population().species().size());
}

// The exponent of a generation's time in its genomes' links: least squares through the logarithms of both,
// for 1 to 64 hidden nodes at the start. 1 is linear.
void exponent(benchmark::State& state) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, largest = 0;
  for (auto _ : state)
    for (const std::uint32_t hidden : {1u, 2u, 4u, 8u, 16u, 32u, 64u}) {
      Breeder breeder(150, hidden);
      breeder.begin(1);
      while (!breeder.done()) breeder.next();
      const double links = std::log(breeder.links()), time = std::log(median(breeder.seconds));
      n += 1, x += links, y += time, xx += links * links, xy += links * time;
      state.counters["ns_a_link_" + std::to_string(hidden)] = std::exp(time - links) / 150 * 1e9;
      largest = std::max(largest, breeder.links());
    }
  state.counters["exponent"] = (n * xy - x * y) / (n * xx - x * x);
  state.counters["links"] = largest;
}

const bool registered = [] {
  for (const std::uint32_t size : {150u, 1000u, 10000u})
    for (const std::uint32_t hidden : {1u, 4u}) {
      const std::string name = "neat/" + std::to_string(size) + "x" + std::to_string(hidden);
      benchmark::RegisterBenchmark(name.c_str(), [=](auto& state) {
        generation(state, size, hidden);
      })->Unit(benchmark::kMillisecond);
    }
  benchmark::RegisterBenchmark("neat/exponent", exponent)->Unit(benchmark::kMillisecond)->Iterations(1);
  return true;
}();

}  // namespace

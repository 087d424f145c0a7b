// A HyperNEAT phenotype, 20x15 depth sheet -> 10x8 -> 7 outputs: from the CPPN's genome to the compiled
// network.
#include <benchmark/benchmark.h>

#include <vector>

#include "common/random.h"
#include "neat/express.h"
#include "neat/population.h"

namespace {

void phenotype(benchmark::State& state) {
  evograsp::proto::NeatConfig config;
  config.set_population(50);
  config.mutable_hyperneat();
  auto population = evograsp::neat::Population::create(config, 304, 7, 1).value();
  evograsp::Random random(1, evograsp::Purpose::kTestHarness);
  for (int g = 0; g < 30; ++g) {  // CPPNs as 30 generations leave them
    std::vector<double> fitness(population.ask().size());
    for (double& f : fitness) f = random.uniform();
    population.tell(fitness);
  }
  evograsp::neat::Expressor expressor(config);
  std::size_t i = 0;
  double links = 0, genes = 0;
  for (auto _ : state) {
    const auto& genome = population.ask()[i++ % population.ask().size()];
    const evograsp::Network network = expressor.express(genome);
    links += network.links();
    genes += genome.links();
  }
  state.counters["links"] = benchmark::Counter(links, benchmark::Counter::kAvgIterations);
  state.counters["cppn_links"] = benchmark::Counter(genes, benchmark::Counter::kAvgIterations);
}

const bool registered =
    benchmark::RegisterBenchmark("hyperneat/20x15", phenotype)->Unit(benchmark::kMillisecond) != nullptr;

}  // namespace

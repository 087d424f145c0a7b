#include "cli/bench_genome.h"

#include <algorithm>
#include <vector>

#include "common/digest.h"
#include "common/network_pack.h"
#include "common/random.h"
#include "neat/genome.h"
#include "neat/population.h"

namespace evograsp::cli {
namespace {

constexpr std::uint32_t kHidden = 5;
constexpr int kOutputs = 7, kGenerations = 20, kTries = 3;

Result<neat::Population> bred(const proto::NeatConfig& config, int inputs) {
  auto population = neat::Population::create(config, inputs, kOutputs, 1);
  Random random(1, Purpose::kTestHarness);
  for (int g = 0; population && g < kGenerations; ++g) {
    std::vector<double> fitness(config.population());
    for (double& f : fitness) f = random.uniform();
    population->tell(fitness);
  }
  return population;
}

}  // namespace

Result<BenchGenome> bench_genome(std::size_t genome_bytes) {
  proto::NeatConfig config;
  config.set_population(20);
  config.set_hidden(kHidden);
  BenchGenome best;
  double inputs = std::max(1.0, static_cast<double>(genome_bytes) / 50);
  for (int i = 0; i < kTries; ++i) {
    const auto population = bred(config, std::max(1, static_cast<int>(inputs)));
    if (!population) return tl::unexpected(population.error());
    const neat::Genome& genome = population->ask().back();
    const proto::Network network = neat::express_proto(genome, config);
    best = {deterministic_bytes(neat::to_proto(genome)).size(), deterministic_bytes(network).size(),
            pack_network(network)};
    inputs *= static_cast<double>(genome_bytes) / static_cast<double>(best.genome_bytes);
  }
  return best;
}

}  // namespace evograsp::cli

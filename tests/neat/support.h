// Shared by the tests of this room.
#pragma once

#include <vector>

#include "common/random.h"
#include "neat/population.h"

namespace evograsp::neat::testing {

// Fitness that depends on the genome alone and rewards some weights: cheap selection pressure.
inline double weigh(const Genome& genome) {
  double sum = 0;
  for (std::uint32_t i = 0; i < genome.links(); ++i)
    if (genome.enabled(i))
      sum += static_cast<double>(genome.weight(i)) * ((i * 2654435761u >> 16) % 3 == 0 ? 1 : -0.5);
  return 10.0 + sum / (1.0 + genome.links());
}

inline std::vector<double> weigh(std::span<const Genome> genomes) {
  std::vector<double> fitness;
  for (const Genome& genome : genomes) fitness.push_back(weigh(genome));
  return fitness;
}

inline void evolve(Population& population, int generations) {
  for (int g = 0; g < generations; ++g) population.tell(weigh(population.ask()));
}

// A lively config: every operator has a chance.
inline proto::NeatConfig lively(std::uint32_t size = 60) {
  proto::NeatConfig config;
  config.set_population(size);
  config.set_hidden(2);
  config.set_target_species(6);
  config.set_toggle_enabled(0.1);
  config.set_reenable(0.1);
  config.set_mutate_bias(0.2);
  config.set_mutate_activation(0.1);
  config.set_interspecies(0.05);
  config.set_mate_average(0.2);
  for (const auto f : {proto::TANH, proto::SINE, proto::GAUSSIAN, proto::RELU}) config.add_hidden_choice(f);
  return config;
}

}  // namespace evograsp::neat::testing

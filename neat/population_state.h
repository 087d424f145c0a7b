// The inside of a Population: shared by its evolution (population.cpp) and its storage (state.cpp).
#pragma once

#include <optional>

#include "neat/archive.h"
#include "neat/innovation.h"
#include "neat/population.h"
#include "neat/reproduction.h"
#include "neat/species.h"

namespace evograsp::neat {

struct EvolutionState {
  proto::NeatConfig config;  // as given, HyperNEAT's own defaults filled in
  std::uint32_t inputs, outputs;
  std::uint64_t run_seed;
  std::shared_ptr<const StartStructure> start;
  Innovations innovations;
  Speciation speciation;

  std::uint32_t generation = 0;
  std::uint64_t next_genome = 0;
  std::uint32_t next_species = 1;
  double best = 0;  // fitness so far
  std::uint32_t best_generation = 0;
  std::vector<Genome> genomes, previous;  // previous: storage for the next generation
  std::vector<Species> species;
  std::vector<SpeciesSummary> judged;
  std::optional<Archive> archive = {};  // with config.archive

  // tell(), in parts: population.cpp.
  std::optional<Ranking> look_about(std::span<const double> fitness, std::span<const Behaviour> behaviour);
  std::vector<std::uint32_t> share_out(const Ranking& fitness, const Ranking& selection,
                                       std::uint32_t places);

  // Everything but genomes and species. kInvalid as create().
  static Result<std::unique_ptr<EvolutionState>> make(const proto::NeatConfig& config, int inputs,
                                                      int outputs, std::uint64_t run_seed);
};

}  // namespace evograsp::neat

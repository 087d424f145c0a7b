// NEAT (Stanley and Miikkulainen 2002) as a pure machine: ask for genomes, tell their fitness. No I/O, no
// threads, no clock. Whoever evaluates is not its business.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/network.h"
#include "common/result.h"
#include "neat/archive.h"
#include "neat/genome.h"
#include "proto/config.pb.h"
#include "proto/genome.pb.h"

namespace evograsp::neat {

struct SpeciesSummary {
  std::uint32_t id = 0;
  std::uint32_t age = 0;            // generations judged, this one included
  std::uint32_t last_improved = 0;  // its age when its best fitness last rose
  std::uint32_t size = 0;
  double best = 0, mean = 0;  // of this generation; invalid fitness counts as the worst valid one, at most 0
};

struct EvolutionState;

// Not thread-safe; moves freely between threads.
class Population {
 public:
  // inputs, outputs: of the networks that come out. Random streams are keyed by run_seed: nothing else
  // decides. kInvalid when the config contradicts itself or the counts.
  static Result<Population> create(const proto::NeatConfig& config, int inputs, int outputs,
                                   std::uint64_t run_seed);
  // Of save()'s bytes, with the config they were made with. Everything in them is checked.
  static Result<Population> load(const proto::NeatConfig& config, std::string_view state);
  std::string save() const;  // deterministic bytes; load(save()) continues to the same bytes

  Population(Population&&) noexcept;
  Population& operator=(Population&&) noexcept;
  ~Population();

  std::uint32_t generation() const;  // of the genomes that ask() gives; starts at 0
  // As many as config.population; valid until tell().
  std::span<const Genome> ask() const;
  // fitness[i] belongs to ask()[i]; NaN and infinities count as the worst. Makes the next generation: ranks,
  // drops stagnant species (the best one never), shares fitness, allots children, breeds, sorts into species.
  // With config.archive, behaviour[i] is what ask()[i] did: see archive.h and docs/NEAT.md for what it
  // changes. Without, it is not looked at.
  void tell(std::span<const double> fitness, std::span<const Behaviour> behaviour = {});
  // Of the population that the last tell() judged, by id.
  const std::vector<SpeciesSummary>& species() const;
  // Index into ask() of each member, by species, as the genomes now stand.
  std::vector<std::vector<std::uint32_t>> members() const;
  double threshold() const;
  const Archive* archive() const;  // null without config.archive

 private:
  // Storage and evolution share the inside (population_state.h).
  explicit Population(std::unique_ptr<EvolutionState> state);
  std::unique_ptr<EvolutionState> state_;
};

// The phenotype of a genome: compiled feed-forward or recurrent network; of a CPPN, its substrate's network.
Network express(const Genome& genome, const proto::NeatConfig& config);
proto::Network express_proto(const Genome& genome, const proto::NeatConfig& config);

}  // namespace evograsp::neat

// NEAT (Stanley and Miikkulainen 2002) as a pure machine: ask for genomes, tell their fitness. No I/O, no
// threads, no clock. Whoever evaluates is not its business.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/network.h"
#include "common/result.h"
#include "proto/config.pb.h"
#include "proto/genome.pb.h"

namespace evograsp::neat {

class Genome;

struct SpeciesSummary {
  std::uint32_t id = 0;
  std::uint32_t age = 0;
  std::uint32_t last_improved = 0;
  std::uint32_t size = 0;
  double best = 0, mean = 0;
};

// Not thread-safe; moves freely between threads.
class Population {
 public:
  // Random streams are keyed by run_seed: nothing else decides what comes out.
  static Result<Population> create(const proto::NeatConfig& config, int inputs, int outputs,
                                   std::uint64_t run_seed);
  static Result<Population> load(const proto::NeatConfig& config, std::string_view state);
  std::string save() const;  // deterministic bytes; load(save()) continues to the same bytes

  Population(Population&&) noexcept;
  Population& operator=(Population&&) noexcept;
  ~Population();

  std::uint32_t generation() const;  // of the genomes that ask() gives; starts at 0
  std::span<const Genome> ask() const;
  // fitness[i] belongs to ask()[i]; NaN and infinities count as the worst. Makes the next generation.
  void tell(std::span<const double> fitness);
  // Of the population that the last tell() judged.
  std::vector<SpeciesSummary> species() const;
  double threshold() const;

 private:
  struct State;
  explicit Population(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// The phenotype of a genome: compiled feed-forward or recurrent network; of a CPPN, its substrate's network.
proto::Network express_proto(const Genome& genome, const proto::NeatConfig& config);

}  // namespace evograsp::neat

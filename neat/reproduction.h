// Who has how many children (Stanley and Miikkulainen 2002, sections 3.3 and 4.1).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/random.h"
#include "neat/crossover.h"
#include "neat/genome.h"
#include "neat/innovation.h"
#include "neat/species.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

// Whole numbers in proportion to the shares (not negative, finite), by largest remainder, earlier first on a
// tie: they sum to `total` exactly. All shares zero: equal parts.
std::vector<std::uint32_t> allot(std::span<const double> shares, std::uint32_t total);

// A generation's fitness, made fit for comparison: higher is better, NaN and infinities come last.
class Ranking {
 public:
  explicit Ranking(std::span<const double> fitness);
  bool better(std::uint32_t a, std::uint32_t b) const;  // strict weak order; equal fitness: lower index first
  bool equal(std::uint32_t a, std::uint32_t b) const {
    return valid_[a] == valid_[b] && fitness_[a] == fitness_[b];
  }
  double fitness(std::uint32_t i) const {
    return fitness_[i];
  }  // the worst valid one, at most 0, if not valid
  double shared(std::uint32_t i) const { return fitness_[i] - shift_; }  // not negative
  std::uint32_t best() const { return best_; }

 private:
  std::vector<double> fitness_;
  std::vector<std::uint8_t> valid_;
  double shift_ = 0;
  std::uint32_t best_ = 0;
};

// What reproduction needs to know; all of it outlives the call.
struct Parents {
  std::span<const Genome> genomes;
  const std::vector<Species>& species;  // members ranked, best first
  const Ranking& ranking;
  std::span<const std::uint32_t> children;  // of each species
};

// Fills `next` (as long as the population; storage is used again). Child c draws from
// Random(run_seed, kReproduction, generation, c) alone and, unless it is a champion kept unchanged, has id
// next_genome + c.
void reproduce(const Parents& parents, const proto::NeatConfig& config, std::uint64_t run_seed,
               std::uint32_t generation, Innovations& innovations, std::uint64_t& next_genome,
               std::span<Genome> next);

}  // namespace evograsp::neat

// Speciation (Stanley and Miikkulainen 2002, section 3.3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "neat/distance.h"
#include "neat/genome.h"

namespace evograsp::neat {

struct Species {
  std::uint32_t id = 0;
  std::uint32_t age = 0;               // generations it has been judged in
  std::uint32_t improved = 0;          // its age when its best fitness last rose
  double best = 0;                     // best fitness it ever had
  std::vector<std::uint32_t> members;  // indices into the population, ascending until they are ranked
};

// Sorts genomes into species: each joins the first whose representative is nearer than `threshold`, or founds
// one. Between calls the caller's population may change entirely.
class Speciation {
 public:
  Speciation(const DistanceWeights& weights, double threshold, std::uint32_t target)
      : weights_(weights), threshold_(threshold), target_(target) {}

  double threshold() const { return threshold_; }
  void set_threshold(double threshold) { threshold_ = threshold; }

  // First generation: with a target, looks for the threshold that gives about `target` species (distances of
  // many random weights lie close together, so that a number in a config rarely does), then sorts.
  void found(std::span<const Genome> genomes, std::vector<Species>& species, std::uint32_t& next_id);

  // Later generations: representative[s] stands for species[s]. With a target the threshold is steered:
  // raised by up to 5 or lowered by up to 3 percent by how many species there were, then further, and the
  // sorting begun again, while there are more than twice or less than half as many as wanted. Species left
  // without a member are dropped.
  void sort(std::span<const Genome> genomes, std::span<const Genome* const> representative,
            std::vector<Species>& species, std::uint32_t& next_id);

 private:
  bool try_sort(std::span<const Genome> genomes, std::span<const Genome* const> representative,
                std::size_t limit, std::vector<Species>& species, std::uint32_t next_id) const;

  DistanceWeights weights_;
  double threshold_;
  std::uint32_t target_;
};

}  // namespace evograsp::neat

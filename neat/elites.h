// What the map of elites adds to the next generation (Mouret and Clune 2015, figure 2: "randomly select an
// elite, vary it").
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "neat/archive.h"
#include "neat/innovation.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

// Places of a generation that are not the species'.
struct ElitePlaces {
  std::uint32_t again = 0;     // for elites, unchanged
  std::uint32_t children = 0;  // for theirs
};
// None without an archive, of another kind than MAP_ELITES, or while it is empty.
ElitePlaces elite_places(const std::optional<Archive>& archive, const proto::NeatConfig& config);

// Fills next from `first` on. First come the elites that were judged least often (of these the fittest),
// those left out that stand in next already; a child takes the place of one that is missing. Child k: two
// elites, each as likely as any, are crossed with chance config.crossover, else the first is copied; then it
// is mutated. It draws from Random(run_seed, kArchive, generation, k) alone.
void reproduce_elites(const Archive& archive, const ElitePlaces& places, const proto::NeatConfig& config,
                      std::uint64_t run_seed, std::uint32_t generation, Innovations& innovations,
                      std::uint64_t& next_genome, std::span<Genome> next, std::uint32_t first);

}  // namespace evograsp::neat

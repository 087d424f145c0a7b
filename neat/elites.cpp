#include "neat/elites.h"

#include <algorithm>
#include <set>
#include <vector>

#include "common/random.h"
#include "neat/crossover.h"
#include "neat/mutation.h"

namespace evograsp::neat {
namespace {

using Elites = std::vector<const Elite*>;  // by cell

// The one whose structure a child gets: the fitter; of equals the smaller one, then the first.
bool gives_structure(const Elite& a, const Elite& b) {
  if (a.fitness() != b.fitness()) return a.fitness() > b.fitness();
  return a.genome.links() <= b.genome.links();
}

void make_child(const Elites& elites, const proto::NeatConfig& config, Random& random, Genome& child) {
  const auto count = static_cast<std::uint32_t>(elites.size());
  const std::uint32_t a = random.below(count);
  const bool cross = random.chance(config.crossover());
  const std::uint32_t b = cross ? random.below(count) : a;
  if (a == b) {
    child = elites[a]->genome;
    return;
  }
  const bool first = gives_structure(*elites[std::min(a, b)], *elites[std::max(a, b)]);
  const Elite& fitter = *elites[first ? std::min(a, b) : std::max(a, b)];
  const Elite& other = *elites[first ? std::max(a, b) : std::min(a, b)];
  crossover(fitter.genome, other.genome, config, random, child);
}

Elites by_need(const Elites& elites) {
  Elites order = elites;
  std::stable_sort(order.begin(), order.end(), [](const Elite* a, const Elite* b) {
    if (a->judged != b->judged) return a->judged < b->judged;
    return a->fitness() > b->fitness();
  });
  return order;
}

}  // namespace

ElitePlaces elite_places(const std::optional<Archive>& archive, const proto::NeatConfig& config) {
  if (!archive || config.archive().kind() != proto::MAP_ELITES || archive->elites().empty()) return {};
  const double size = config.population();
  const auto elites = static_cast<std::uint32_t>(archive->elites().size());
  ElitePlaces places;
  places.again = std::min(static_cast<std::uint32_t>(config.archive().again() * size), elites);
  places.children = std::min(static_cast<std::uint32_t>(config.archive().children() * size),
                             config.population() - places.again);
  return places;
}

void reproduce_elites(const Archive& archive, const ElitePlaces& places, const proto::NeatConfig& config,
                      std::uint64_t run_seed, std::uint32_t generation, Innovations& innovations,
                      std::uint64_t& next_genome, std::span<Genome> next, std::uint32_t first) {
  Elites elites;
  for (const auto& [cell, elite] : archive.elites()) elites.push_back(&elite);
  std::set<std::uint64_t> there;
  for (const Genome& genome : next.first(first)) there.insert(genome.id());
  std::uint32_t c = first;
  for (const Elite* elite : by_need(elites)) {
    if (c == first + places.again) break;
    if (there.contains(elite->genome.id())) continue;
    next[c++] = elite->genome;
  }
  for (std::uint32_t k = 0; c < first + places.again + places.children; ++c, ++k) {
    Random random(run_seed, Purpose::kArchive, generation, k);
    make_child(elites, config, random, next[c]);
    mutate(next[c], config, innovations, random);
    next[c].set_id(next_genome++);
  }
}

}  // namespace evograsp::neat

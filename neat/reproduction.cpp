#include "neat/reproduction.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "neat/mutation.h"

namespace evograsp::neat {
namespace {

std::uint32_t survivors(const Species& species, const proto::NeatConfig& config) {
  const double count = std::ceil(config.survival() * static_cast<double>(species.members.size()));
  return std::clamp(static_cast<std::uint32_t>(count), 1u,
                    static_cast<std::uint32_t>(species.members.size()));
}

std::uint32_t draw_parent(const Species& species, const proto::NeatConfig& config, Random& random) {
  return species.members[random.below(survivors(species, config))];
}

// The second parent of a crossover in species s.
std::uint32_t draw_mate(const Parents& parents, std::size_t s, const proto::NeatConfig& config,
                        Random& random) {
  const auto count = static_cast<std::uint32_t>(parents.species.size());
  if (random.chance(config.interspecies()) && count > 1) {
    const std::uint32_t other = random.below(count - 1);
    return draw_parent(parents.species[other < s ? other : other + 1], config, random);
  }
  return draw_parent(parents.species[s], config, random);
}

// Which parent's disjoint and excess links a child gets: the fitter's; equally fit, the smaller one's.
bool gives_structure(const Parents& parents, std::uint32_t a, std::uint32_t b) {
  if (!parents.ranking.equal(a, b)) return parents.ranking.better(a, b);
  const std::uint32_t of_a = parents.genomes[a].links(), of_b = parents.genomes[b].links();
  return of_a != of_b ? of_a < of_b : a < b;
}

void make_child(const Parents& parents, std::size_t s, const proto::NeatConfig& config, Random& random,
                Genome& child) {
  std::uint32_t a = draw_parent(parents.species[s], config, random);
  if (!random.chance(config.crossover())) {
    child = parents.genomes[a];
    return;
  }
  std::uint32_t b = draw_mate(parents, s, config, random);
  if (a == b) {
    child = parents.genomes[a];
    return;
  }
  if (!gives_structure(parents, a, b)) std::swap(a, b);
  crossover(parents.genomes[a], parents.genomes[b], config, random, child);
}

}  // namespace

std::vector<std::uint32_t> allot(std::span<const double> shares, std::uint32_t total) {
  std::vector<std::uint32_t> parts(shares.size(), 0);
  if (shares.empty()) return parts;
  const double largest = *std::max_element(shares.begin(), shares.end());
  std::vector<double> scaled(shares.size(), 1.0);
  if (largest > 0)
    std::transform(shares.begin(), shares.end(), scaled.begin(), [&](double x) { return x / largest; });
  const double sum = std::accumulate(scaled.begin(), scaled.end(), 0.0);
  std::vector<std::pair<double, std::size_t>> remainder;
  std::uint32_t given = 0;
  for (std::size_t s = 0; s < shares.size(); ++s) {
    const double exact = scaled[s] / sum * total;
    parts[s] = std::min(static_cast<std::uint32_t>(exact), total - given);
    given += parts[s];
    remainder.emplace_back(parts[s] - exact, s);
  }
  std::sort(remainder.begin(), remainder.end());  // no two are equal: s differs
  for (std::size_t k = 0; given < total; k = (k + 1) % remainder.size(), ++given)
    ++parts[remainder[k].second];
  return parts;
}

Ranking::Ranking(std::span<const double> fitness) : fitness_(fitness.begin(), fitness.end()) {
  double worst = 0;
  constexpr double kMost = 1e100;  // sums and differences stay finite
  for (double& f : fitness_) {
    valid_.push_back(std::isfinite(f));
    f = valid_.back() != 0 ? std::clamp(f, -kMost, kMost) : 0.0;
    worst = std::min(worst, f);
  }
  shift_ = worst;
  for (std::size_t i = 0; i < fitness_.size(); ++i)
    if (valid_[i] == 0) fitness_[i] = worst;
  for (std::uint32_t i = 1; i < fitness_.size(); ++i)
    if (better(i, best_)) best_ = i;
}

bool Ranking::better(std::uint32_t a, std::uint32_t b) const {
  if (valid_[a] != valid_[b]) return valid_[a] > valid_[b];
  if (fitness_[a] != fitness_[b]) return fitness_[a] > fitness_[b];
  return a < b;
}

void reproduce(const Parents& parents, const proto::NeatConfig& config, std::uint64_t run_seed,
               std::uint32_t generation, Innovations& innovations, std::uint64_t& next_genome,
               std::span<Genome> next) {
  innovations.next_generation();
  std::uint32_t c = 0;
  for (std::size_t s = 0; s < parents.species.size(); ++s) {
    const Species& species = parents.species[s];
    const bool keep_champion =
        config.elite_min_size() > 0 && species.members.size() >= config.elite_min_size();
    for (std::uint32_t k = 0; k < parents.children[s]; ++k, ++c) {
      if (k == 0 && keep_champion) {
        next[c] = parents.genomes[species.members.front()];
        continue;
      }
      Random random(run_seed, Purpose::kReproduction, generation, c);
      make_child(parents, s, config, random, next[c]);
      mutate(next[c], config, innovations, random);
      next[c].set_id(next_genome + c);
    }
  }
  next_genome += c;
}

}  // namespace evograsp::neat

#include "neat/species.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace evograsp::neat {
namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

void drop_empty(std::vector<Species>& species, std::uint32_t& next_id) {
  for (const Species& s : species) next_id = std::max(next_id, s.id + 1);
  std::erase_if(species, [](const Species& s) { return s.members.empty(); });
}

}  // namespace

// False, with `species` as long as it was, when there would be more than `limit` with members.
bool Speciation::try_sort(std::span<const Genome> genomes, std::span<const Genome* const> representative,
                          std::size_t limit, std::vector<Species>& species, std::uint32_t next_id) const {
  std::vector<const Genome*> stands(representative.begin(), representative.end());
  const std::size_t old = species.size();
  std::size_t inhabited = 0;
  for (Species& s : species) s.members.clear();
  for (std::uint32_t i = 0; i < genomes.size(); ++i) {
    std::size_t s = 0;
    while (s < stands.size() && distance(genomes[i], *stands[s], weights_) >= threshold_) ++s;
    if (s == stands.size()) {
      stands.push_back(&genomes[i]);
      species.push_back({.id = next_id++, .members = {}});
    }
    inhabited += species[s].members.empty();
    if (inhabited > limit) {
      species.resize(old);
      return false;
    }
    species[s].members.push_back(i);
  }
  return true;
}

void Speciation::found(std::span<const Genome> genomes, std::vector<Species>& species,
                       std::uint32_t& next_id) {
  species.clear();
  if (target_ > 0 && genomes.size() > 1) {
    constexpr std::size_t kSample = 1000;
    constexpr int kHalvings = 12;
    const std::span<const Genome> sample = genomes.first(std::min(genomes.size(), kSample));
    double low = 0, high = 0;
    for (const Genome& genome : sample) high = std::max(high, distance(sample[0], genome, weights_));
    high = 1.25 * high + 1e-9;
    for (int k = 0; k < kHalvings; ++k) {
      threshold_ = 0.5 * (low + high);
      species.clear();
      const bool few = try_sort(sample, {}, target_, species, 0);
      if (few && species.size() == target_) break;
      (few ? high : low) = threshold_;
    }
    species.clear();
  }
  try_sort(genomes, {}, kNoLimit, species, next_id);
  drop_empty(species, next_id);
}

void Speciation::sort(std::span<const Genome> genomes, std::span<const Genome* const> representative,
                      std::vector<Species>& species, std::uint32_t& next_id) {
  if (target_ == 0) {
    try_sort(genomes, representative, kNoLimit, species, next_id);
    return drop_empty(species, next_id);
  }
  const double wanted = target_, had = static_cast<double>(species.size());
  threshold_ *= 1.0 + std::clamp(0.1 * (had - wanted) / wanted, -0.03, 0.05);
  constexpr int kRetries = 40;  // raises the threshold 45-fold at most
  int k = 0;
  while (k < kRetries && !try_sort(genomes, representative, std::size_t{2} * target_, species, next_id)) {
    threshold_ *= 1.1;
    ++k;
  }
  if (k == kRetries) try_sort(genomes, representative, kNoLimit, species, next_id);
  drop_empty(species, next_id);
}

}  // namespace evograsp::neat

#include "neat/species.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace evograsp::neat {
namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

std::size_t inhabited(const std::vector<Species>& species) {
  return static_cast<std::size_t>(
      std::count_if(species.begin(), species.end(), [](const Species& s) { return !s.members.empty(); }));
}

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
  std::size_t used = 0;
  for (Species& s : species) s.members.clear();
  for (std::uint32_t i = 0; i < genomes.size(); ++i) {
    std::size_t s = 0;
    while (s < stands.size() && distance(genomes[i], *stands[s], weights_) >= threshold_) ++s;
    if (s == stands.size()) {
      stands.push_back(&genomes[i]);
      species.push_back({.id = next_id++, .members = {}});
    }
    used += species[s].members.empty();
    if (used > limit) {
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
  const std::size_t old = species.size();
  threshold_ *= 1.0 + std::clamp(0.1 * (had - wanted) / wanted, -0.03, 0.05);
  // Below too_low there are too many, from too_high on too few. Too many are never accepted; too few are when
  // they cannot be helped (distances that lie close together leave little between one species and one a
  // genome).
  double too_low = 0, too_high = std::numeric_limits<double>::infinity();
  constexpr int kPatience = 16;
  for (int tries = 1;; ++tries, species.resize(old)) {
    if (!try_sort(genomes, representative, std::size_t{2} * target_, species, next_id)) {
      too_low = threshold_;
      if (std::isinf(too_high))
        threshold_ = threshold_ * 1.1 + 1e-9;
      else
        threshold_ = tries < kPatience ? 0.5 * (too_low + too_high) : too_high;
    } else if (2 * inhabited(species) < target_ && tries < kPatience) {
      too_high = threshold_;
      threshold_ = too_low > 0 ? 0.5 * (too_low + too_high) : threshold_ * 0.9;
    } else {
      break;
    }
  }
  drop_empty(species, next_id);
}

}  // namespace evograsp::neat

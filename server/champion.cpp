#include "server/champion.h"

#include <set>
#include <string_view>
#include <tuple>

namespace evograsp::server {

std::vector<BestRecord> candidates(const std::vector<BestRecord>& bests) {
  std::vector<BestRecord> kept;
  std::set<std::string_view> seen;
  for (const BestRecord& best : bests)
    if (seen.insert(best.network).second) kept.push_back(best);
  return kept;
}

std::size_t choose(const std::vector<ValidationRecord>& validations) {
  const auto better = [](const ValidationRecord& a, const ValidationRecord& b) {
    return std::make_tuple(-static_cast<double>(a.successes), -a.fitness, a.generation) <
           std::make_tuple(-static_cast<double>(b.successes), -b.fitness, b.generation);
  };
  std::size_t best = 0;
  for (std::size_t i = 1; i < validations.size(); ++i)
    if (better(validations[i], validations[best])) best = i;
  return best;
}

}  // namespace evograsp::server

#include "server/champion.h"

#include <algorithm>
#include <numeric>
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

std::vector<std::size_t> ranking(const std::vector<ValidationRecord>& validations) {
  const auto key = [&](std::size_t i) {
    const ValidationRecord& v = validations[i];
    const double grasped = v.trials > 0 ? static_cast<double>(v.successes) / v.trials : 0;
    const double lifted = v.lift_trials > 0 ? static_cast<double>(v.lifts) / v.lift_trials : -1;
    return std::make_tuple(v.lift_trials == 0, -(grasped + lifted), -v.fitness, v.generation, i);
  };
  std::vector<std::size_t> order(validations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return order;
}

std::size_t choose(const std::vector<ValidationRecord>& validations) {
  return ranking(validations).front();
}

}  // namespace evograsp::server

#include "server/race.h"

#include <algorithm>
#include <cmath>

namespace evograsp::server {

namespace {

double finite_mean(const std::vector<double>& scores) {
  const double mean = mean_of(scores);
  return std::isfinite(mean) ? mean : -HUGE_VAL;
}

// Whether `behind` is worse than `leader` beyond doubt.
bool beaten(const std::vector<double>& leader, const std::vector<double>& behind, double deviations) {
  const auto n = static_cast<double>(leader.size());
  double sum = 0, squares = 0;
  for (std::size_t k = 0; k < leader.size(); ++k) sum += leader[k] - behind[k];
  const double mean = sum / n;
  for (std::size_t k = 0; k < leader.size(); ++k) {
    const double d = leader[k] - behind[k] - mean;
    squares += d * d;
  }
  if (leader.size() < 2 || !std::isfinite(mean)) return !std::isfinite(mean);
  return mean > deviations * std::sqrt(squares / (n - 1) / n);
}

}  // namespace

double mean_of(const std::vector<double>& scores) {
  double sum = 0;
  for (const double score : scores) sum += score;
  return scores.empty() ? 0 : sum / static_cast<double>(scores.size());
}

std::vector<std::uint32_t> racers(const proto::RaceConfig& config,
                                  const std::vector<std::vector<double>>& scores,
                                  std::vector<std::uint32_t> racing) {
  if (racing.empty()) return racing;
  std::sort(racing.begin(), racing.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double fa = finite_mean(scores[a]), fb = finite_mean(scores[b]);
    return fa != fb ? fa > fb : a < b;
  });
  const double kept = std::ceil(config.keep() * static_cast<double>(racing.size()));
  racing.resize(std::clamp<std::size_t>(static_cast<std::size_t>(kept), 1, racing.size()));
  const std::vector<double>& leader = scores[racing.front()];
  std::erase_if(racing, [&](std::uint32_t i) {
    return i != racing.front() && beaten(leader, scores[i], config.deviations());
  });
  return racing;
}

}  // namespace evograsp::server

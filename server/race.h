// Who goes on to optional trials: racing among a generation's candidates (RaceConfig).
#pragma once

#include <cstdint>
#include <vector>

#include "proto/config.pb.h"

namespace evograsp::server {

// Of the candidates still racing, those that go on, the best first (equal means: the lower index). scores[i]:
// the fitness of each trial of genome i; all racing have had the same trials, one at least. The best `keep`
// share of the racing (one at least), less those whose mean lies more than `deviations` standard errors of
// the paired difference below the leader's (Birattari, Stuetzle, Paquete and Varrentrapp 2002, "A racing
// algorithm for configuring metaheuristics"; a normal quantile in place of Student's). Deterministic.
std::vector<std::uint32_t> racers(const proto::RaceConfig& config,
                                  const std::vector<std::vector<double>>& scores,
                                  std::vector<std::uint32_t> racing);

double mean_of(const std::vector<double>& scores);

}  // namespace evograsp::server

// Which network a run gives out.
#pragma once

#include <vector>

#include "server/store_records.h"

namespace evograsp::server {

// The bests of the last generations, each network once (an elite that stayed best is the candidate of the
// first generation it was best in). In the order of `bests`.
std::vector<BestRecord> candidates(const std::vector<BestRecord>& bests);

// Indices of the candidates, the best first. Those that were lifted come before the others, by the share of
// successes plus the share of lifts that held; the rest by most successes; then highest mean fitness, then
// the earlier generation.
std::vector<std::size_t> ranking(const std::vector<ValidationRecord>& validations);

// Index of the one to give out: the first of the ranking. One validation a candidate; not empty.
std::size_t choose(const std::vector<ValidationRecord>& validations);

}  // namespace evograsp::server

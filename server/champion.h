// Which network a run gives out.
#pragma once

#include <vector>

#include "server/store_records.h"

namespace evograsp::server {

// The bests of the last generations, each network once (an elite that stayed best is the candidate of the
// first generation it was best in). In the order of `bests`.
std::vector<BestRecord> candidates(const std::vector<BestRecord>& bests);

// Index of the one to give out: most successes, then highest mean fitness, then the earlier generation. One
// validation a candidate; not empty.
std::size_t choose(const std::vector<ValidationRecord>& validations);

}  // namespace evograsp::server

// What a grasp takes here: a worker's declaration before its first task, so that machines of different speeds
// are given different tasks from the start. Affects no result.
#pragma once

#include "sim/simulator.h"

namespace evograsp::worker {

// Seconds a grasp attempt, the mean of a few on placements of its own; takes about 10 ms. 0: none could be
// held.
double measure_grasp(const sim::Simulator& simulator);

}  // namespace evograsp::worker

// Which hidden nodes and links depend on which: cycles and evaluation order, each linear in the links.
#pragma once

#include <cstdint>
#include <vector>

#include "neat/genome.h"

namespace evograsp::neat {

// True if a link source -> target would close a cycle, disabled links counted (they may be enabled again).
// Depth-first search over the links between nodes that compute: O(links).
bool closes_cycle(const Genome& genome, std::uint32_t source, std::uint32_t target);

// True if the genome's links, disabled ones included, hold no cycle. O(links).
bool is_acyclic(const Genome& genome);

}  // namespace evograsp::neat

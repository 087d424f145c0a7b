// Crossover by historical marking (Stanley and Miikkulainen 2002, section 3.2, figure 4).
#pragma once

#include "common/random.h"
#include "neat/genome.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

// Makes `child` from two parents of one population; storage that the child has is used again. Links that both
// have come from either parent at random (or, with chance mate_average a crossover, are averaged); one that
// is disabled in either parent is disabled in the child with chance disabled_in_either, else enabled.
// Disjoint and excess links, and nodes, come from the fitter parent. So the child's links are a subset of its
// fitter parent's: nothing dangles and no cycle can arise. Linear in the links.
void crossover(const Genome& fitter, const Genome& other, const proto::NeatConfig& config, Random& random,
               Genome& child);

}  // namespace evograsp::neat

// The compatibility distance (Stanley and Miikkulainen 2002, equation 1).
#pragma once

#include "neat/genome.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

struct DistanceWeights {
  double excess, disjoint, weight;  // c1, c2, c3
  bool by_genes;
  explicit DistanceWeights(const proto::NeatConfig& config)
      : excess(config.c1_excess()),
        disjoint(config.c2_disjoint()),
        weight(config.c3_weight()),
        by_genes(config.normalise_by_genes()) {}
};

// c1 E / N + c2 D / N + c3 W: E excess and D disjoint links, W the mean difference of matching links' weights
// (0 if none match), N the links of the larger genome, or 1 if both have fewer than 20 or by_genes is false.
// Of two genomes of one population. Symmetric to the bit, zero on itself, linear in the links.
double distance(const Genome& a, const Genome& b, const DistanceWeights& c);

}  // namespace evograsp::neat

// The mutations (Stanley and Miikkulainen 2002, sections 3.1 and 4.1). Each draws from the child's own
// stream.
#pragma once

#include "common/random.h"
#include "neat/genome.h"
#include "neat/innovation.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

// Every weight: with chance perturb_weight moved by up to +-perturb_power, else drawn anew from
// +-initial_weight; both times the link's scale; kept within +-max_weight. One 64-bit draw a link.
void mutate_weights(Genome& genome, const proto::NeatConfig& config, Random& random);

// Splits an enabled link chosen uniformly (those from the bias node excepted: a node behind one would be a
// second bias). It is disabled; the link into the new node weighs 1, the link out of it what the old one did.
// Returns false if no link can be split, or the run has no node numbers left.
bool add_node(Genome& genome, const proto::NeatConfig& config, Innovations& innovations, Random& random);

// A new link between nodes that had none, weight drawn from +-initial_weight; feed-forward genomes stay so.
// Gives up after 32 draws of a pair: returns false.
bool add_connection(Genome& genome, const proto::NeatConfig& config, Innovations& innovations,
                    Random& random);

void toggle_enabled(Genome& genome, Random& random);  // of one link
void reenable(Genome& genome);                        // the oldest disabled link
void mutate_biases(Genome& genome, const proto::NeatConfig& config, Random& random);
void mutate_activation(Genome& genome, const proto::NeatConfig& config,
                       Random& random);  // of one hidden node

// How far generation `generation` (from 0) moves weights: perturb_power 2^(-generation / perturb_halving), or
// always perturb_power without halving. Wide steps find the region, small ones the best of it (simulated
// annealing's idea).
double perturb_power(const proto::NeatConfig& config, std::uint32_t generation);

// All of the above, each with its chance.
void mutate(Genome& genome, const proto::NeatConfig& config, Innovations& innovations, Random& random);

// Of a new hidden node.
Activation draw_activation(const proto::NeatConfig& config, Random& random);

}  // namespace evograsp::neat

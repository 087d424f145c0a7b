// What the first generation looks like.
#pragma once

#include "common/random.h"
#include "neat/genome.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

// The links all genomes of the run start with, by config.topology. The last
// config.other_inputs inputs are not depth (click, box, features) when there are more: depth_weight_scale
// leaves them alone, and FEATURES links them (and the bias) alone, to `hidden` nodes and the outputs, all but
// the bias with a fifth of its initial weights.
std::shared_ptr<const StartStructure> make_start(const proto::NeatConfig& config, std::uint32_t inputs,
                                                 std::uint32_t outputs);
// Innovations below this are the start's (of the sparse topology: reserved for every input-output pair).
std::uint32_t first_free_innovation(const proto::NeatConfig& config, const StartStructure& start);
// A genome of the first generation: random weights and, when sparse, random links.
Genome make_first(const proto::NeatConfig& config, const std::shared_ptr<const StartStructure>& start,
                  Random& random);

}  // namespace evograsp::neat

// From genotype to phenotype, directly or, for a CPPN, by way of its substrate.
#pragma once

#include <optional>

#include "common/network.h"
#include "neat/genome.h"
#include "neat/genome_compiler.h"
#include "neat/hyperneat.h"
#include "proto/config.pb.h"

namespace evograsp::neat {

// Makes the networks of many genomes of one population: what express() of population.h does, faster the
// second time. Not thread-safe.
class Expressor {
 public:
  // A config that Population::create() accepted.
  explicit Expressor(const proto::NeatConfig& config) : compiler_(config.recurrent()) {
    if (config.has_hyperneat()) substrate_ = Substrate::make(config).value();
  }

  Network express(const Genome& genome) {
    if (substrate_) return substrate_->express(genome, compiler_);
    return Network::from_sound_columns(compiler_.columns(genome));
  }
  // The message of the same network, without compiling it; `out` is overwritten and its storage used again.
  void express(const Genome& genome, proto::Network& out);

 private:
  GenomeCompiler compiler_;
  std::optional<Substrate> substrate_;
};

}  // namespace evograsp::neat

// A network as NEAT breeds them, of a given size: what benchmarks send about.
#pragma once

#include <cstddef>
#include <string>

#include "common/result.h"

namespace evograsp::cli {

struct BenchGenome {
  std::size_t genome_bytes = 0;   // of its genotype (proto/genome.proto)
  std::size_t network_bytes = 0;  // of its phenotype as protobuf
  std::string packed;             // as it travels (common/network_pack.h)
};

// One of a small population that has been bred for some generations with random fitness; its genotype takes
// about `genome_bytes`, 500 at least.
Result<BenchGenome> bench_genome(std::size_t genome_bytes);

}  // namespace evograsp::cli

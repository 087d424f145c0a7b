// How much memory a generation takes at the master, before it does: one that does not fit is refused in
// words, and resumable, instead of being killed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/result.h"
#include "neat/genome.h"
#include "proto/config.pb.h"

namespace evograsp::server {

// Bytes at the largest moment of a generation: parents and children, each child's network as it travels, the
// children on their way to the store, scores of every trial. An estimate, rather too high: docs/SIZING.md.
std::uint64_t footprint(std::span<const neat::Genome> genomes, std::size_t trials);

// kIo (5: memory) when that is more than config.run.memory_mb, and says what to change. Where nothing is
// said, than three quarters of `machine_bytes`.
Status check_footprint(const proto::Config& config, std::span<const neat::Genome> genomes, std::size_t trials,
                       std::uint64_t machine_bytes);

// What this process may use: the machine's memory, or less when its control group says so.
std::uint64_t machine_memory();

}  // namespace evograsp::server

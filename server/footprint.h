// How much memory a generation takes at the master, before it does: one that does not fit is refused in
// words, and resumable, instead of being killed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/result.h"
#include "neat/genome.h"

namespace evograsp::server {

// Bytes at the largest moment of a generation: parents and children, each child's network as it travels, the
// children on their way to the store, scores of every trial. An estimate, rather too high: docs/SIZING.md.
std::uint64_t footprint(std::span<const neat::Genome> genomes, std::size_t trials);

// kIo (5: memory) when that is more than `limit`, in bytes; says what to change.
Status check_footprint(std::span<const neat::Genome> genomes, std::size_t trials, std::uint64_t limit);

// What a generation may take: EVOGRASP_MEMORY_MB, or three quarters of the machine's memory, or of the
// control group's (Slurm, systemd and Kubernetes set one) when that is less. Bytes.
std::uint64_t memory_limit();

}  // namespace evograsp::server

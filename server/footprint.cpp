#include "server/footprint.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

namespace evograsp::server {

namespace {

constexpr std::uint64_t kBytesAGenome = 3500;  // ids, judgements, journal entry, dispatcher's books
constexpr std::uint64_t kBytesALink =
    15;  // packed network, and the population's columns on their way to disk
constexpr std::uint64_t kBytesATrial = 16;
constexpr std::uint64_t kMegabyte = 1000000;

}  // namespace

std::uint64_t footprint(std::span<const neat::Genome> genomes, std::size_t trials) {
  std::uint64_t bytes = 0;
  for (const neat::Genome& genome : genomes)
    bytes += 2 * genome.bytes() + genome.links() * kBytesALink + kBytesAGenome + trials * kBytesATrial;
  return bytes;
}

Status check_footprint(const proto::Config& config, std::span<const neat::Genome> genomes, std::size_t trials,
                       std::uint64_t machine_bytes) {
  const std::uint64_t asked = config.run().memory_mb() * kMegabyte;
  const std::uint64_t limit = asked > 0 ? asked : machine_bytes / 4 * 3;
  const std::uint64_t needed = footprint(genomes, trials);
  if (needed <= limit) return {};
  std::uint64_t links = 0;
  for (const neat::Genome& genome : genomes) links += genome.links();
  return fail(ErrorCode::kIo,
              "a generation of " + std::to_string(genomes.size()) + " genomes with " +
                  std::to_string(links / genomes.size()) + " links each and " + std::to_string(trials) +
                  " trials takes about " + std::to_string(needed / kMegabyte) + " MB here, allowed are " +
                  std::to_string(limit / kMegabyte) +
                  (asked > 0 ? " (run.memory_mb)"
                             : " (three quarters of the machine; run.memory_mb sets another limit)") +
                  ": a smaller neat.population or a larger machine");
}

std::uint64_t machine_memory() {
  const auto pages = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PHYS_PAGES)));
  const std::uint64_t machine = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::uint64_t group = 0;
  std::ifstream file("/sys/fs/cgroup/memory.max");
  return file >> group && group > 0 ? std::min(group, machine) : machine;
}

}  // namespace evograsp::server

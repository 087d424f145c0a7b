#include "server/footprint.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
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

Status check_footprint(std::span<const neat::Genome> genomes, std::size_t trials, std::uint64_t limit) {
  const std::uint64_t needed = footprint(genomes, trials);
  if (needed <= limit) return {};
  std::uint64_t links = 0;
  for (const neat::Genome& genome : genomes) links += genome.links();
  return fail(ErrorCode::kIo, "a generation of " + std::to_string(genomes.size()) + " genomes with " +
                                  std::to_string(links / genomes.size()) + " links each and " +
                                  std::to_string(trials) + " trials takes about " +
                                  std::to_string(needed / kMegabyte) + " MB here, allowed are " +
                                  std::to_string(limit / kMegabyte) +
                                  " (EVOGRASP_MEMORY_MB, or three quarters of the machine): a smaller "
                                  "neat.population, or more memory");
}

std::uint64_t memory_limit() {
  const char* asked = std::getenv("EVOGRASP_MEMORY_MB");
  if (const std::uint64_t megabytes = asked != nullptr ? std::strtoull(asked, nullptr, 10) : 0; megabytes > 0)
    return megabytes * kMegabyte;
  const auto pages = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PHYS_PAGES)));
  const std::uint64_t machine = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::uint64_t group = 0;
  std::ifstream file("/sys/fs/cgroup/memory.max");
  return (file >> group && group > 0 ? std::min(group, machine) : machine) / 4 * 3;
}

}  // namespace evograsp::server

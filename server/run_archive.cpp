// The map of grasps as run.db keeps it: the rows that a generation changed.
#include "common/digest.h"
#include "score/grasp_measure.h"
#include "server/run_loop.h"

namespace evograsp::server {
namespace {

double measured(const proto::ArchiveAxis& axis, double place) {
  const score::MeasureRange range = score::range_of(axis);
  return range.low + place * (range.high - range.low);
}

}  // namespace

void RunLoop::describe_elites(Committed& entry) {
  const neat::Archive* archive = population_.archive();
  if (archive == nullptr) return;
  const proto::ArchiveConfig& config = config_.neat().archive();
  proto::Network network;
  for (const std::uint32_t cell : archive->changed()) {
    const auto found = archive->elites().find(cell);
    if (found == archive->elites().end()) {
      entry.emptied.push_back(cell);
      continue;
    }
    const neat::Elite& elite = found->second;
    EliteRecord& row = entry.elites.emplace_back();
    row.cell = cell;
    row.x = cell % archive->columns();
    row.y = cell / archive->columns();
    row.x_value = measured(config.x(), elite.behaviour().x);
    row.y_value = measured(config.y(), elite.behaviour().y);
    row.fitness = elite.fitness();
    row.judged = elite.judged;
    row.genome = elite.genome.id();
    row.generation = elite.generation;
    row.updated = entry.record.generation;
    row.genotype = deterministic_bytes(neat::to_proto(elite.genome));
    expressor_.express(elite.genome, network);
    row.network = deterministic_bytes(network);
  }
}

}  // namespace evograsp::server

// A population's stored state: read back, it goes on, and it stores as it was read.
#include <vector>

#include "neat/population.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace evograsp;

proto::NeatConfig config_of(unsigned kind) {
  proto::NeatConfig config;
  config.set_population(6);
  if (kind == 1) config.set_recurrent(true);
  if (kind == 2) {
    config.mutable_hyperneat()->set_input_columns(2);
    config.mutable_hyperneat()->set_input_rows(2);
    auto& sheet = *config.mutable_hyperneat()->add_hidden_sheet();
    sheet.set_columns(2);
    sheet.set_rows(2);
  }
  return config;
}

// Large networks are legal but slow to breed: the search stays with small ones.
bool small(const neat::Population& population) {
  std::size_t links = 0;
  for (const neat::Genome& genome : population.ask()) links += genome.links();
  return links < 100'000;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Pieces pieces(data, size);
  const proto::NeatConfig config = config_of(pieces.byte() % 3);
  auto population = neat::Population::load(config, pieces.rest());
  if (!population) return 0;
  const std::string saved = population->save();
  auto again = neat::Population::load(config, saved);
  fuzz::require(again.has_value(), "what has been loaded can be stored and loaded");
  fuzz::require(again->save() == saved, "and stays the same");
  if (!small(*population)) return 0;
  std::vector<double> fitness;
  for (const neat::Genome& genome : population->ask()) {
    neat::express(genome, config);
    fitness.push_back(static_cast<double>(genome.links()));
  }
  for (int generation = 0; generation < 3; ++generation) population->tell(fitness);
  return 0;
}

// Storage of a population: proto/population.proto. What is read back may be damaged or strange: all is
// checked.
#include <google/protobuf/arena.h>

#include <cmath>
#include <string>

#include "common/digest.h"
#include "neat/population_state.h"
#include "proto/population.pb.h"

namespace evograsp::neat {
namespace {

constexpr std::uint32_t kVersion = 1;

tl::unexpected<Error> bad(const std::string& what) {
  return fail(ErrorCode::kInvalid, "population state: " + what);
}

template <class Field, class Range>
void append(Field* field, const Range& range) {
  field->Reserve(static_cast<int>(range.size()));
  field->Add(range.begin(), range.end());
}

void store(const Genome& genome, proto::GenomeState& proto) {
  proto.set_id(genome.id());
  for (std::uint32_t j = 0; j < genome.hidden_nodes(); ++j) proto.add_hidden(genome.hidden_id(j));
  for (std::uint32_t k = 0; k < genome.computed_nodes(); ++k) {
    proto.mutable_activation()->push_back(static_cast<char>(genome.activation(k)));
    proto.add_bias(genome.bias(k));
  }
  append(proto.mutable_innovation(), genome.late_innovation());
  for (const LinkEnds& ends : genome.late_ends()) {
    proto.add_source(ends.source());
    proto.add_target(ends.target());
  }
  append(proto.mutable_weight(), genome.weights());
  append(proto.mutable_enabled(), genome.flags());
}

Status restore_nodes(const proto::GenomeState& proto, std::uint32_t next_node, Genome& genome) {
  const StartStructure& start = genome.start();
  const auto hidden = static_cast<std::uint32_t>(proto.hidden_size());
  const std::uint32_t nodes = start.outputs + hidden;
  if (hidden < start.hidden || proto.activation().size() != nodes ||
      proto.bias_size() != static_cast<int>(nodes))
    return bad("a genome's node columns differ in length");
  std::uint32_t last = start.first_hidden() + start.hidden - 1;
  for (std::uint32_t j = start.hidden; j < hidden; ++j) {
    const std::uint32_t node = proto.hidden(static_cast<int>(j));
    if (node <= last || node >= next_node)
      return bad("a genome's hidden nodes do not ascend, or are not born yet");
    last = node;
    genome.insert_hidden(node, Activation::kTanh, 0.0f);
  }
  for (std::uint32_t k = 0; k < nodes; ++k) {
    genome.set_activation(k, static_cast<Activation>(proto.activation()[k]));
    genome.set_bias(k, proto.bias(static_cast<int>(k)));
  }
  return {};
}

Status restore_links(const proto::GenomeState& proto, std::uint32_t next_innovation, Genome& genome) {
  const int start = static_cast<int>(genome.start_links()), late = proto.innovation_size();
  if (proto.source_size() != late || proto.target_size() != late || proto.weight_size() != start + late)
    return bad("a genome's link columns differ in length");
  if (proto.enabled_size() != (start + late + 63) / 64) return bad("a genome's flags have the wrong length");
  std::uint32_t last = genome.start_links();
  for (int k = 0; k < late; ++k) {
    if (proto.innovation(k) <= last || proto.innovation(k) >= next_innovation)
      return bad("a genome's innovations do not ascend, or are not made yet");
    last = proto.innovation(k);
    genome.insert({last, proto.source(k), proto.target(k), 0.0f, true});
  }
  for (int i = 0; i < start + late; ++i) {
    genome.set_weight(static_cast<std::uint32_t>(i), proto.weight(i));
    genome.set_enabled(static_cast<std::uint32_t>(i), (proto.enabled(i / 64) >> (i % 64) & 1) != 0);
  }
  return {};
}

Result<Genome> restore(const proto::GenomeState& proto, const EvolutionState& state) {
  Genome genome(state.start, Activation::kTanh, Activation::kTanh);
  genome.set_id(proto.id());
  if (proto.id() >= state.next_genome) return bad("a genome is not born yet");
  if (Status s = restore_nodes(proto, state.innovations.next_node(), genome); !s)
    return tl::unexpected(s.error());
  if (Status s = restore_links(proto, state.innovations.next_innovation(), genome); !s)
    return tl::unexpected(s.error());
  if (Status s = check(genome, state.config.recurrent()); !s) return bad(s.error().message);
  return genome;
}

// Species hold each genome exactly once.
Status restore_species(const proto::PopulationState& proto, EvolutionState& state) {
  std::vector<std::uint8_t> seen(state.genomes.size(), 0);
  std::size_t members = 0;
  for (const proto::SpeciesState& p : proto.species()) {
    Species species{.id = p.id(),
                    .age = p.age(),
                    .improved = p.improved(),
                    .best = p.best(),
                    .members = {p.member().begin(), p.member().end()}};
    if (p.member_size() == 0 || p.id() >= state.next_species || p.improved() > p.age() ||
        !std::isfinite(p.best()))
      return bad("species " + std::to_string(p.id()) + " cannot be");
    if (!state.species.empty() && p.id() <= state.species.back().id) return bad("species do not ascend");
    for (const std::uint32_t i : species.members) {
      if (i >= seen.size() || seen[i] != 0) return bad("species do not part the population");
      seen[i] = 1;
    }
    members += species.members.size();
    state.species.push_back(std::move(species));
  }
  if (members != state.genomes.size()) return bad("species do not part the population");
  for (const proto::JudgedSpecies& j : proto.judged())
    state.judged.push_back({j.id(), j.age(), j.last_improved(), j.size(), j.best(), j.mean()});
  return {};
}

void store(const Archive& archive, proto::ArchiveState& proto) {
  for (const auto& [cell, elite] : archive.elites()) {
    proto::EliteState& p = *proto.add_elite();
    p.set_cell(cell);
    store(elite.genome, *p.mutable_genome());
    p.set_generation(elite.generation);
    p.set_judged(elite.judged);
    p.set_fitness(elite.fitness_sum);
    p.set_x(elite.x_sum);
    p.set_y(elite.y_sum);
  }
  for (const Behaviour& b : archive.memory()) {
    proto.add_memory(b.x);
    proto.add_memory(b.y);
  }
}

Status restore_archive(const proto::PopulationState& proto, EvolutionState& state) {
  if (proto.has_archive() != state.archive.has_value())
    return bad("it was made with another neat.archive than the config's");
  for (const proto::EliteState& p : proto.archive().elite()) {
    Result<Genome> genome = restore(p.genome(), state);
    if (!genome) return tl::unexpected(genome.error());
    if (p.generation() > proto.generation()) return bad("an elite is not born yet");
    Elite elite{std::move(*genome), p.generation(), p.judged(), p.fitness(), p.x(), p.y()};
    if (Status s = state.archive->restore_elite(p.cell(), std::move(elite)); !s) return s;
  }
  if (proto.archive().memory_size() % 2 != 0) return bad("its memory of what was novel cannot be");
  for (int i = 0; i < proto.archive().memory_size(); i += 2)
    if (Status s = state.archive->restore_memory({proto.archive().memory(i), proto.archive().memory(i + 1)});
        !s)
      return s;
  return {};
}

Status restore_counters(const proto::PopulationState& proto, EvolutionState& state) {
  if (proto.start_links() != state.start->links() ||
      proto.genome_size() != static_cast<int>(state.config.population()))
    return bad("it was made with another topology or population size than the config's");
  if (proto.next_innovation() < state.innovations.next_innovation() ||
      proto.next_node() < state.innovations.next_node() || proto.next_node() > kMaxNodeNumbers ||
      !(proto.threshold() >= 0) || !std::isfinite(proto.threshold()) || !std::isfinite(proto.best()) ||
      proto.best_generation() > proto.generation())
    return bad("its counters cannot be");
  state.generation = proto.generation();
  state.innovations = {proto.next_innovation(), proto.next_node()};
  state.next_genome = proto.next_genome();
  state.next_species = proto.next_species();
  state.best = proto.best();
  state.best_generation = proto.best_generation();
  state.speciation.set_threshold(proto.threshold());
  return {};
}

}  // namespace

std::string Population::save() const {
  const EvolutionState& state = *state_;
  google::protobuf::Arena arena;
  proto::PopulationState& proto = *google::protobuf::Arena::CreateMessage<proto::PopulationState>(&arena);
  proto.set_version(kVersion);
  proto.set_inputs(state.inputs);
  proto.set_outputs(state.outputs);
  proto.set_run_seed(state.run_seed);
  proto.set_generation(state.generation);
  proto.set_next_innovation(state.innovations.next_innovation());
  proto.set_next_node(state.innovations.next_node());
  proto.set_next_genome(state.next_genome);
  proto.set_next_species(state.next_species);
  proto.set_threshold(threshold());
  proto.set_best(state.best);
  proto.set_best_generation(state.best_generation);
  proto.set_start_links(state.start->links());
  for (const Genome& genome : state.genomes) store(genome, *proto.add_genome());
  for (const Species& s : state.species) {
    proto::SpeciesState& p = *proto.add_species();
    p.set_id(s.id);
    p.set_age(s.age);
    p.set_improved(s.improved);
    p.set_best(s.best);
    append(p.mutable_member(), s.members);
  }
  for (const SpeciesSummary& s : state.judged) {
    proto::JudgedSpecies& p = *proto.add_judged();
    p.set_id(s.id);
    p.set_age(s.age);
    p.set_last_improved(s.last_improved);
    p.set_size(s.size);
    p.set_best(s.best);
    p.set_mean(s.mean);
  }
  if (state.archive) store(*state.archive, *proto.mutable_archive());
  return deterministic_bytes(proto);
}

Result<Population> Population::load(const proto::NeatConfig& config, std::string_view bytes) {
  proto::PopulationState proto;
  if (!proto.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return bad("not a population, or cut short");
  if (proto.version() != kVersion)
    return fail(ErrorCode::kUnsupported, "population state: version " + std::to_string(proto.version()) +
                                             " is not known; " + std::to_string(kVersion) + " is");
  constexpr std::uint32_t kMost = 1'000'000;
  auto made = EvolutionState::make(config, static_cast<int>(std::min(proto.inputs(), kMost + 1)),
                                   static_cast<int>(std::min(proto.outputs(), kMost + 1)), proto.run_seed());
  if (!made) return tl::unexpected(made.error());
  EvolutionState& state = **made;
  if (Status s = restore_counters(proto, state); !s) return tl::unexpected(s.error());
  for (const proto::GenomeState& p : proto.genome()) {
    Result<Genome> genome = restore(p, state);
    if (!genome) return tl::unexpected(genome.error());
    state.genomes.push_back(std::move(*genome));
  }
  if (Status s = restore_species(proto, state); !s) return tl::unexpected(s.error());
  if (Status s = restore_archive(proto, state); !s) return tl::unexpected(s.error());
  return Population(std::move(*made));
}

}  // namespace evograsp::neat

#include "neat/population.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "neat/elites.h"
#include "neat/express.h"
#include "neat/mutation.h"
#include "neat/population_state.h"
#include "neat/reproduction.h"
#include "neat/start.h"

namespace evograsp::neat {
namespace {

tl::unexpected<Error> bad(const std::string& what) {
  return fail(ErrorCode::kInvalid, "neat: " + what);
}

// What the schema's ranges do not say.
Status check_config(const proto::NeatConfig& config, int inputs, int outputs) {
  if (inputs < 1 || outputs < 1) return bad("inputs and outputs must be at least 1");
  if (inputs > 1'000'000 || outputs > 1'000'000) return bad("inputs and outputs must be at most 1000000");
  const std::uint64_t i = static_cast<std::uint64_t>(inputs) + 1, o = static_cast<std::uint64_t>(outputs);
  if (config.population() < 2 || config.population() > 1'000'000)
    return bad("population must be 2 to 1000000");
  const std::uint64_t links =
      config.topology() == proto::HIDDEN_LAYER && config.hidden() > 0 ? config.hidden() * (i + o) : i * o;
  if (config.topology() != proto::UNCONNECTED && links > Network::kMaxLinks)
    return bad("the start topology has more than 4194304 links");
  const double limit = static_cast<double>(Network::kMaxWeight);
  if (!(config.max_weight() > 0 && config.max_weight() <= limit))
    return bad("max_weight must be above 0, at most 1048576");
  for (const double x : {config.initial_weight(), config.perturb_power(), config.depth_weight_scale()})
    if (!(x >= 0 && x <= limit))
      return bad("initial_weight, perturb_power and depth_weight_scale must be 0 to 1048576");
  for (const double x : {config.c1_excess(), config.c2_disjoint(), config.c3_weight(), config.threshold()})
    if (!(x >= 0 && std::isfinite(x))) return bad("c1, c2, c3 and threshold must not be negative");
  if (!(config.survival() > 0 && config.survival() <= 1)) return bad("survival must be above 0, at most 1");
  if (config.archive().kind() == proto::NOVELTY && config.has_archive() && config.population() > 20'000)
    return bad("archive: novelty compares all with all; population must be at most 20000");
  if (config.archive().children() + config.archive().again() > 1)
    return bad("archive: children and again are shares of the population: at most 1 together");
  return {};
}

// Ranks members for selection, notes ages and improvements in fitness, and says what there was.
void judge(const Ranking& fitness, const Ranking& selection, std::vector<Species>& species,
           std::vector<SpeciesSummary>& judged) {
  judged.clear();
  for (Species& s : species) {
    std::sort(s.members.begin(), s.members.end(), [&](auto a, auto b) { return selection.better(a, b); });
    double best = fitness.fitness(s.members.front());
    for (const std::uint32_t i : s.members) best = std::max(best, fitness.fitness(i));
    ++s.age;
    if (s.age == 1 || best > s.best) {
      s.best = best;
      s.improved = s.age;
    }
    double sum = 0;
    for (const std::uint32_t i : s.members) sum += fitness.fitness(i);
    const auto size = static_cast<std::uint32_t>(s.members.size());
    judged.push_back({s.id, s.age, s.improved, size, best, sum / size});
  }
}

// Index of the species that holds the generation's best genome.
std::size_t best_species(const std::vector<Species>& species, const Ranking& ranking) {
  std::size_t best = 0;
  for (std::size_t s = 1; s < species.size(); ++s)
    if (ranking.better(species[s].members.front(), species[best].members.front())) best = s;
  return best;
}

// Explicit fitness sharing: a species' share is the mean of its members' fitness (above the worst, should
// that be negative); a stagnant species has none.
std::vector<double> shares(const std::vector<Species>& species, const Ranking& ranking,
                           const proto::NeatConfig& config, std::size_t best) {
  std::vector<double> share;
  for (std::size_t s = 0; s < species.size(); ++s) {
    const bool stagnant =
        config.drop_off_age() > 0 && species[s].age - species[s].improved >= config.drop_off_age();
    double sum = 0;
    const double size = static_cast<double>(species[s].members.size());
    if (s == best || !stagnant)
      for (const std::uint32_t i : species[s].members) sum += ranking.shared(i) / size;
    share.push_back(sum);
  }
  return share;
}

// "If the fitness of the entire population does not improve for more than 20 generations, only the top two
// species are allowed to reproduce" (section 4.1 of the paper).
std::vector<double> top_two(const std::vector<Species>& species, const Ranking& ranking, std::size_t best) {
  std::size_t second = best == 0 ? 1 : 0;
  for (std::size_t s = 0; s < species.size(); ++s)
    if (s != best && ranking.better(species[s].members.front(), species[second].members.front())) second = s;
  std::vector<double> share(species.size(), 0.0);
  share[best] = share[second] = 1.0;
  return share;
}

// The config that the genomes themselves are bred by. CPPNs: no input is a depth sample, and new nodes draw
// from the functions whose patterns HyperNEAT is known for unless the config names some.
proto::NeatConfig genome_config(const proto::NeatConfig& config) {
  proto::NeatConfig result = config;
  if (!config.has_hyperneat()) return result;
  result.set_depth_weight_scale(1);
  if (result.hidden_choice_size() == 0)
    for (const auto f :
         {proto::TANH, proto::SINE, proto::GAUSSIAN, proto::LINEAR, proto::ABS, proto::STEEP_SIGMOID})
      result.add_hidden_choice(f);
  return result;
}

}  // namespace

Result<std::unique_ptr<EvolutionState>> EvolutionState::make(const proto::NeatConfig& given, int inputs,
                                                             int outputs, std::uint64_t run_seed) {
  auto ends =
      std::pair(static_cast<std::uint32_t>(inputs), static_cast<std::uint32_t>(outputs));  // of the genomes
  const proto::NeatConfig config = genome_config(given);
  if (config.has_hyperneat()) {
    const auto substrate = Substrate::make(config);
    if (!substrate) return tl::unexpected(substrate.error());
    if (ends != std::pair(substrate->inputs(), substrate->outputs()))
      return bad("hyperneat describes networks of " + std::to_string(substrate->inputs()) + " inputs and " +
                 std::to_string(substrate->outputs()) + " outputs, " + std::to_string(inputs) + " and " +
                 std::to_string(outputs) + " are needed: set hyperneat.input_columns, input_rows, outputs");
    ends = {kCppnInputs, substrate->cppn_outputs()};
  }
  if (Status status = check_config(config, static_cast<int>(ends.first), static_cast<int>(ends.second));
      !status)
    return tl::unexpected(status.error());
  auto start = make_start(config, ends.first, ends.second);
  const std::uint32_t innovation = first_free_innovation(config, *start);
  const std::uint32_t node = start->first_hidden() + start->hidden;
  const std::uint32_t target = std::min(config.target_species(), config.population() / 2);
  auto state = std::unique_ptr<EvolutionState>(
      new EvolutionState{.config = config,
                         .inputs = static_cast<std::uint32_t>(inputs),
                         .outputs = static_cast<std::uint32_t>(outputs),
                         .run_seed = run_seed,
                         .start = std::move(start),
                         .innovations = {innovation, node},
                         .speciation = {DistanceWeights(config), config.threshold(), target},
                         .genomes = {},
                         .previous = {},
                         .species = {},
                         .judged = {}});
  if (config.has_archive()) state->archive.emplace(config.archive());
  return state;
}

Result<Population> Population::create(const proto::NeatConfig& config, int inputs, int outputs,
                                      std::uint64_t run_seed) {
  auto made = EvolutionState::make(config, inputs, outputs, run_seed);
  if (!made) return tl::unexpected(made.error());
  EvolutionState& state = **made;
  for (std::uint32_t i = 0; i < config.population(); ++i) {
    Random random(run_seed, Purpose::kInitialPopulation, 0, i);
    state.genomes.push_back(make_first(state.config, state.start, random));
    state.genomes.back().set_id(++state.next_genome);
  }
  ++state.next_genome;
  state.speciation.found(state.genomes, state.species, state.next_species);
  return Population(std::move(*made));
}

Population::Population(std::unique_ptr<EvolutionState> state) : state_(std::move(state)) {}
Population::Population(Population&&) noexcept = default;
Population& Population::operator=(Population&&) noexcept = default;
Population::~Population() = default;

std::uint32_t Population::generation() const {
  return state_->generation;
}
std::span<const Genome> Population::ask() const {
  return state_->genomes;
}
const std::vector<SpeciesSummary>& Population::species() const {
  return state_->judged;
}
double Population::threshold() const {
  return state_->speciation.threshold();
}
const Archive* Population::archive() const {
  return state_->archive ? &*state_->archive : nullptr;
}

std::vector<std::vector<std::uint32_t>> Population::members() const {
  std::vector<std::vector<std::uint32_t>> result;
  for (const Species& s : state_->species) result.push_back(s.members);
  return result;
}

// What selection goes by, if that is not fitness alone.
std::optional<Ranking> EvolutionState::look_about(std::span<const double> fitness,
                                                  std::span<const Behaviour> given) {
  if (!archive) return std::nullopt;
  std::vector<Behaviour> behaviour(given.begin(), given.end());
  behaviour.resize(genomes.size());  // nothing is known of the others
  for (Behaviour& b : behaviour)
    if (b.known()) b = {std::clamp(b.x, 0.0, 1.0), std::clamp(b.y, 0.0, 1.0)};
  archive->add(generation, genomes, fitness, behaviour);
  if (config.archive().kind() != proto::NOVELTY) return std::nullopt;
  const std::vector<double> novelty = archive->novelty(behaviour);
  archive->remember(behaviour, novelty);
  return Ranking(selection_scores(fitness, novelty, config.archive().weight()));
}

// Of each species, by the shares; none has all, and the best keeps a place.
std::vector<std::uint32_t> EvolutionState::share_out(const Ranking& fitness, const Ranking& selection,
                                                     std::uint32_t places) {
  const std::size_t leader = best_species(species, selection);
  std::vector<double> share = shares(species, selection, config, leader);
  const double best_fitness = fitness.fitness(fitness.best());
  if (generation == 0 || best_fitness > best) {
    best = best_fitness;
    best_generation = generation;
  } else if (config.refocus_age() > 0 && generation - best_generation > config.refocus_age() &&
             species.size() > 2) {
    share = top_two(species, selection, leader);
    best_generation = generation;
  }
  std::vector<std::uint32_t> children = allot(share, places);
  if (children[leader] == 0 && places > 0) {  // shared away: the best species keeps a place all the same
    --*std::max_element(children.begin(), children.end());
    ++children[leader];
  }
  return children;
}

void Population::tell(std::span<const double> fitness, std::span<const Behaviour> behaviour) {
  EvolutionState& state = *state_;
  std::vector<double> told(fitness.begin(), fitness.end());
  told.resize(state.genomes.size(), std::nan(""));  // a genome nobody judged is among the worst
  const Ranking ranking(told);
  const std::optional<Ranking> other = state.look_about(told, behaviour);
  const Ranking& selection = other ? *other : ranking;
  judge(ranking, selection, state.species, state.judged);

  const ElitePlaces elites = elite_places(state.archive, state.config);
  const auto places = static_cast<std::uint32_t>(told.size()) - elites.again - elites.children;
  const std::vector<std::uint32_t> children = state.share_out(ranking, selection, places);
  proto::NeatConfig config = state.config;
  config.set_perturb_power(perturb_power(config, state.generation));
  state.previous.resize(state.genomes.size());
  const std::span<Genome> next = state.previous;
  reproduce({state.genomes, state.species, selection, children}, config, state.run_seed, state.generation,
            state.innovations, state.next_genome, next.first(places));
  if (elites.again + elites.children > 0)
    reproduce_elites(*state.archive, elites, config, state.run_seed, state.generation, state.innovations,
                     state.next_genome, next, places);
  std::swap(state.genomes, state.previous);

  // A random genome of each species of the old generation stands for it in the new one (section 3.3).
  std::vector<const Genome*> representative;
  for (const Species& s : state.species) {
    Random random(state.run_seed, Purpose::kSpeciation, state.generation, s.id);
    representative.push_back(
        &state.previous[s.members[random.below(static_cast<std::uint32_t>(s.members.size()))]]);
  }
  ++state.generation;
  state.speciation.sort(state.genomes, representative, state.species, state.next_species);
}

Network express(const Genome& genome, const proto::NeatConfig& config) {
  return Expressor(config).express(genome);
}

proto::Network express_proto(const Genome& genome, const proto::NeatConfig& config) {
  return express(genome, config).to_proto();
}

}  // namespace evograsp::neat

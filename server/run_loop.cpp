#include "server/run_loop.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/digest.h"
#include "common/log.h"
#include "common/network_pack.h"
#include "neat/genome.h"
#include "server/champion.h"
#include "server/footprint.h"

namespace evograsp::server {

namespace {

constexpr double kProgressSeconds = 0.2;
constexpr std::size_t kMostCommitting = 64;  // generations the disk may lag behind
constexpr std::size_t kFirstNetworks = 16;   // expressed before they are handed to the dispatcher

}  // namespace

RunLoop::RunLoop(const ResumePoint& start, neat::Population population, Store& store, Dispatcher& dispatcher,
                 Gather& gather, Callbacks callbacks)
    : config_(start.info.config),
      fingerprint_(start.info.experiment.fingerprint()),
      store_(store),
      dispatcher_(dispatcher),
      gather_(gather),
      callbacks_(std::move(callbacks)),
      population_(std::move(population)),
      expressor_(config_.neat()),
      journalled_(start.evaluations),
      decided_rounds_(start.rounds),
      validated_(start.validations),
      bests_(start.bests.begin(), start.bests.end()),
      judged_generations_(start.generation) {
  for (const Evaluation& e : start.optional)
    journalled_optional_[{e.generation, e.stage, e.genome}] = e.measurements;
  position_.generation = start.generation;
  if (start.history.empty()) return;
  const GenerationRecord& last = start.history.back();
  last_best_ = last.best;
  seconds_before_ = last.seconds;
  trials_ = last.trials;
  evaluations_ = last.evaluations;
  position_.committed = last;
  position_.trials = last.trials;
  for (const GenerationRecord& record : start.history)
    position_.best_ever = std::max(position_.best_ever, record.best);
  for (const BestRecord& best : bests_)
    if (!position_.best || best.fitness > position_.best->fitness) position_.best = best;
}

Result<RunState> RunLoop::run() {
  if (evaluations_ == 0) warn_of_time();
  bool resumed = true;  // only the first generation may have been evaluated in part
  while (!evolved()) {
    if (Status status = evolve_one(resumed); !status) return tl::unexpected(status.error());
    if (stopped_) break;
    resumed = false;
  }
  commit_judged();
  if (!stopped_) {
    if (Status status = wait_for_commits(0); !status) return tl::unexpected(status.error());
    if (Status status = validate(); !status) return tl::unexpected(status.error());
  }
  if (stopped_) {
    dispatcher_.abandon();
    if (Status status = wait_for_commits(0); !status) return tl::unexpected(status.error());
    store_.set_state("stopped");
    if (Status status = store_.flush(); !status) return tl::unexpected(status.error());
    return RunState::kStopped;
  }
  position_.phase = "done";
  return RunState::kFinished;
}

bool RunLoop::evolved() const {
  if (judged_generations_ >= config_.run().generations()) return true;
  return judged_generations_ > 0 && config_.run().has_stop_at_fitness() &&
         last_best_ >= config_.run().stop_at_fitness();
}

// ---- one generation ----

Status RunLoop::evolve_one(bool resumed) {
  const std::uint32_t generation = population_.generation();
  const TrialPlan plan = plan_generation(config_, generation);
  generation_start_ = std::chrono::steady_clock::now();
  const auto genomes = population_.ask();
  if (Status status = check_footprint(genomes, plan.trials.size(), memory_limit()); !status) return status;
  position_.generation = generation;
  position_.wanted = static_cast<std::uint32_t>(genomes.size());
  std::vector<Gather::Item> items(genomes.size());
  for (std::size_t i = 0; i < genomes.size(); ++i) items[i] = {genomes[i].id(), generation};
  gather_.begin(Gather::Kind::kGeneration, generation, std::move(items), plan.trials);
  if (resumed) take_journalled();

  const std::vector<std::uint32_t> pending = gather_.pending();
  Work work;
  work.generation = generation;
  work.trial_set = plan.set;
  work.trials = plan.trials;
  work.networks = static_cast<std::uint32_t>(pending.size());
  if (Status status = hand_out(pending, std::move(work)); !status) return status;
  commit_judged();
  if (Status status = wait_for_commits(kMostCommitting); !status) return status;
  if (Status status = wait_for_work(); !status || stopped_) return status;
  std::vector<Judgement> judgements = gather_.take();
  if (Status status = race(judgements); !status || stopped_) return status;
  if (Status status = lift_best(judgements); !status || stopped_) return status;
  judge_generation(plan, judgements);
  return {};
}

// Evaluations that an interrupted server had already journalled.
void RunLoop::take_journalled() {
  const auto genomes = population_.ask();
  std::uint32_t taken = 0;
  const std::size_t trials = plan_generation(config_, population_.generation()).trials.size();
  for (std::uint32_t i = 0; i < genomes.size(); ++i) {
    const auto found = std::find_if(journalled_.begin(), journalled_.end(),
                                    [&](const Evaluation& e) { return e.genome == genomes[i].id(); });
    if (found == journalled_.end()) continue;
    const auto measurements = unpack_measurements(found->measurements);
    if (!measurements || measurements->size() != trials) continue;
    gather_.already(i, gather_.judge(*measurements));
    ++taken;
  }
  if (taken > 0)
    spdlog::info("{} evaluations of generation {} were already done", taken, population_.generation());
  journalled_.clear();
}

// Expressed in batches, each twice the last one, so that workers begin with the first while the last are
// still being made, and the dispatcher is woken few times.
Status RunLoop::hand_out(const std::vector<std::uint32_t>& pending, Work work) {
  if (pending.empty()) return {};
  const auto genomes = population_.ask();
  dispatcher_.begin(std::move(work));
  std::vector<bool> wanted(genomes.size(), false);
  for (const std::uint32_t i : pending) wanted[i] = true;
  std::vector<NetworkFrame> batch;
  std::size_t most = kFirstNetworks;
  proto::Network network;
  std::uint32_t first = 0;
  for (std::uint32_t i = 0; i < genomes.size(); ++i) {
    if (wanted[i]) {
      expressor_.express(genomes[i], network);
      batch.push_back({genomes[i].id(), to_frame(pack_network(network))});
    }
    if (batch.size() < most && i + 1 < genomes.size()) continue;
    most *= 2;
    const auto count = static_cast<std::uint32_t>(batch.size());
    if (count > 0) dispatcher_.add(first, std::exchange(batch, {}));
    first += count;
  }
  return {};
}

void RunLoop::judge_generation(const TrialPlan& plan, const std::vector<Judgement>& judgements) {
  std::vector<double> fitness;
  std::vector<neat::Behaviour> behaviour;
  for (const Judgement& judgement : judgements) {
    fitness.push_back(judgement.fitness);
    behaviour.push_back({judgement.place[0], judgement.place[1]});
  }
  GenerationRecord record = describe(fitness);
  BestRecord best = best_of(fitness);
  record.best_genome = best.genome;
  evaluations_ += fitness.size();
  trials_ += fitness.size() * plan.trials.size();
  record.evaluations = evaluations_;
  record.trials = trials_;
  population_.tell(fitness, behaviour);
  record.species = static_cast<std::uint32_t>(population_.species().size());
  record.threshold = population_.threshold();
  record.seconds = seconds();
  last_best_ = record.best;
  ++judged_generations_;
  bests_.push_back(best);
  while (bests_.size() > config_.champion().candidates()) bests_.pop_front();
  judged_ = Committed{record, std::move(best), population_.species(), {}};
  describe_elites(*judged_);
}

std::string RunLoop::network_bytes(const neat::Genome& genome) {
  proto::Network network;
  expressor_.express(genome, network);
  return deterministic_bytes(network);
}

BestRecord RunLoop::best_of(const std::vector<double>& fitness) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < fitness.size(); ++i)
    if (rank_value(fitness[i]) > rank_value(fitness[best])) best = i;
  const neat::Genome& genome = population_.ask()[best];
  BestRecord record;
  record.generation = population_.generation();
  record.genome = genome.id();
  record.fitness = fitness[best];
  record.genotype = deterministic_bytes(neat::to_proto(genome));
  record.network = network_bytes(genome);
  return record;
}

GenerationRecord RunLoop::describe(const std::vector<double>& fitness) const {
  GenerationRecord record;
  record.generation = population_.generation();
  const auto count = static_cast<double>(fitness.size());
  record.best = *std::max_element(fitness.begin(), fitness.end());
  record.mean = std::accumulate(fitness.begin(), fitness.end(), 0.0) / count;
  double squares = 0, links = 0;
  for (const double f : fitness) squares += (f - record.mean) * (f - record.mean);
  for (const neat::Genome& genome : population_.ask())
    for (const std::uint64_t flags : genome.flags()) links += std::popcount(flags);
  record.deviation = std::sqrt(squares / count);
  record.links = links / count;
  return record;
}

// After the next generation has been handed out, so that the workers need not wait for it.
void RunLoop::commit_judged() {
  if (!judged_) return;
  Committed entry = std::move(*judged_);
  judged_.reset();
  GenerationCommit commit;
  commit.record = entry.record;
  commit.species = entry.species;
  commit.best = entry.best;
  commit.population = population_.save();
  commit.elites = std::move(entry.elites);
  commit.emptied = std::move(entry.emptied);
  {
    const MutexLock lock(mutex_);
    ++committing_;
  }
  store_.commit_generation(std::move(commit), [this, entry = std::move(entry)](const Status& status) mutable {
    entry.status = status;
    {
      const MutexLock lock(mutex_);
      committed_.push_back(std::move(entry));
    }
    gather_.wake();
  });
}

// ---- waiting ----

Status RunLoop::wait_for_work() {
  for (;;) {
    const bool complete = gather_.wait(kProgressSeconds);
    if (Status status = announce(); !status) return status;
    if (Status status = health(); !status) return status;
    if (stopped_) return {};
    follow_pause();
    position_.done = gather_.judged();
    if (complete && !paused_) return {};
    if (complete) gather_.wait_for_wake(kProgressSeconds);
  }
}

Status RunLoop::wait_for_commits(std::size_t most) {
  for (;;) {
    if (Status status = announce(); !status) return status;
    if (Status status = health(); !status) return status;
    {
      const MutexLock lock(mutex_);
      if (committing_ <= most) return {};
    }
    store_.hurry();
    gather_.wait_for_wake(kProgressSeconds);
  }
}

// Tells the world of the generations that are safe by now.
Status RunLoop::announce() {
  std::deque<Committed> safe;
  {
    const MutexLock lock(mutex_);
    safe.swap(committed_);
    committing_ -= safe.size();
  }
  for (Committed& entry : safe) {
    if (!entry.status) return tl::unexpected(entry.status.error());
    const GenerationRecord& r = entry.record;
    position_.committed = r;
    position_.species = std::move(entry.species);
    position_.best_ever = std::max(position_.best_ever, r.best);
    if (!position_.best || entry.best.fitness > position_.best->fitness)
      position_.best = std::move(entry.best);
    if (callbacks_.generation)
      callbacks_.generation({r.generation, r.best, r.mean, r.species, r.trials, r.seconds});
  }
  const auto now = std::chrono::steady_clock::now();
  if (now < next_progress_) return {};
  next_progress_ = now + std::chrono::milliseconds(static_cast<int>(kProgressSeconds * 1000));
  position_.seconds = seconds();
  position_.trials = trials_;
  if (callbacks_.progress) callbacks_.progress();
  return {};
}

Status RunLoop::health() const {
  if (const auto error = gather_.error()) return tl::unexpected(*error);
  return store_.status();
}

void RunLoop::follow_pause() {
  if (paused_ == pause_followed_) return;
  pause_followed_ = paused_;
  store_.set_state(paused_ ? "paused" : "running");
}

void RunLoop::set_paused(bool paused) {
  paused_ = paused;
  dispatcher_.set_paused(paused);
  gather_.wake();
}

void RunLoop::stop() {
  stopped_ = true;
  gather_.wake();
}

double RunLoop::seconds() const {
  return seconds_before_ + std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace evograsp::server

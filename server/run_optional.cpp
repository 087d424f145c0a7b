// Trials beyond the mandatory ones: more grasps for the candidates that still race, lifts for the best.
//
// They are journalled like the mandatory ones, each under its stage.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/digest.h"
#include "common/log.h"
#include "common/network_pack.h"
#include "neat/genome.h"
#include "server/champion.h"
#include "server/race.h"
#include "server/run_loop.h"

namespace evograsp::server {

// Judgements of some genomes of the generation on more trials, in the order given; empty when stopped.
Result<std::vector<Judgement>> RunLoop::try_again(const std::vector<std::uint32_t>& genomes,
                                                  const TrialPlan& plan, bool lifts) {
  const auto population = population_.ask();
  std::vector<BestRecord> candidates;
  for (const std::uint32_t i : genomes) {
    BestRecord candidate;
    candidate.generation = population_.generation();
    candidate.genome = population[i].id();
    candidate.network = network_bytes(population[i]);
    candidates.push_back(std::move(candidate));
  }
  return judge_candidates(candidates, plan, population_.generation(), lifts);
}

Result<std::vector<Judgement>> RunLoop::judge_candidates(const std::vector<BestRecord>& candidates,
                                                         const TrialPlan& plan, std::uint32_t generation,
                                                         bool lifts) {
  std::vector<Gather::Item> items;
  for (const BestRecord& candidate : candidates) items.push_back({candidate.genome, candidate.generation});
  gather_.begin(Gather::Kind::kGeneration, generation, std::move(items), plan.trials, plan.stage);
  take_journalled_optional(candidates, plan, generation);
  std::vector<NetworkFrame> frames;
  for (const std::uint32_t i : gather_.pending()) {
    const auto packed = pack_serialised(candidates[i].network);
    if (!packed) return tl::unexpected(packed.error());
    frames.push_back({candidates[i].genome, to_frame(*packed)});
  }
  if (!frames.empty()) {
    Work work;
    work.generation = generation;
    work.trial_set = plan.set;
    work.trials = plan.trials;
    work.lifts = lifts;
    work.networks = static_cast<std::uint32_t>(frames.size());
    dispatcher_.begin(std::move(work));
    dispatcher_.add(0, std::move(frames));
  }
  if (Status status = wait_for_work(); !status) return tl::unexpected(status.error());
  if (stopped_) return std::vector<Judgement>();
  trials_ += candidates.size() * plan.trials.size();
  return gather_.take();
}

// Those that an interrupted server had already journalled.
void RunLoop::take_journalled_optional(const std::vector<BestRecord>& candidates, const TrialPlan& plan,
                                       std::uint32_t generation) {
  std::uint32_t taken = 0;
  for (std::uint32_t i = 0; i < candidates.size(); ++i) {
    const auto found = journalled_optional_.find({generation, plan.stage, candidates[i].genome});
    if (found == journalled_optional_.end()) continue;
    const auto measurements = unpack_measurements(found->second);
    if (!measurements || measurements->size() != plan.trials.size()) continue;
    gather_.already(i, gather_.judge(*measurements));
    ++taken;
  }
  if (taken > 0)
    spdlog::info("{} evaluations of generation {} ({}) were already done", taken, generation, plan.stage);
}

void RunLoop::warn_of_time() {
  if (config_.race().rounds() == 0 || !config_.race().has_budget_seconds()) return;
  gather_.event(
      true, "time_bound",
      "race.budget_seconds: how many optional trials there are depends on how fast the machines are; "
      "this run can be resumed to the same bytes, but not repeated from its config and seed");
}

// Whether the budget has room for another round. What was decided before an interruption holds.
bool RunLoop::round_is_due(std::uint32_t round, std::optional<std::uint32_t> decided) const {
  if (decided) return round < *decided;
  if (!config_.race().has_budget_seconds()) return true;
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - generation_start_;
  return passed.count() < config_.race().budget_seconds();
}

// Fitness of those that race on is the mean over all the trials they had.
Status RunLoop::race(std::vector<Judgement>& judgements) {
  const proto::RaceConfig& config = config_.race();
  if (config.rounds() == 0) return {};
  std::vector<std::vector<double>> scores;
  for (const Judgement& judgement : judgements) scores.push_back(judgement.scores);
  std::vector<std::uint32_t> racing;
  for (std::uint32_t i = 0; i < judgements.size(); ++i)
    if (!scores[i].empty()) racing.push_back(i);
  const std::optional<std::uint32_t> decided = std::exchange(decided_rounds_, std::nullopt);
  std::uint32_t held = 0;
  for (; held < config.rounds() && round_is_due(held, decided); ++held) {
    racing = racers(config, scores, std::move(racing));
    if (racing.size() < 2) break;
    const TrialPlan plan = plan_optional(config_, population_.generation(), held);
    const auto more = try_again(racing, plan, false);
    if (!more) return tl::unexpected(more.error());
    if (stopped_) return {};
    for (std::size_t k = 0; k < racing.size(); ++k) {
      std::vector<double>& all = scores[racing[k]];
      all.insert(all.end(), (*more)[k].scores.begin(), (*more)[k].scores.end());
      judgements[racing[k]].fitness = mean_of(all);
    }
  }
  if (config.rounds() > 0 && config.has_budget_seconds()) store_.keep_race(population_.generation(), held);
  return {};
}

// In the last lift.generations generations: see LiftConfig. A perfect grasp that is held stays as fit as it
// was.
Status RunLoop::lift_best(std::vector<Judgement>& judgements) {
  const proto::LiftConfig& lift = config_.lift();
  const std::uint64_t generation = population_.generation();
  if (lift.generations() == 0 || generation + lift.generations() < config_.run().generations()) return {};
  std::vector<std::uint32_t> order(judgements.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return rank_value(judgements[a].fitness) > rank_value(judgements[b].fitness);
  });
  order.resize(std::min<std::size_t>(order.size(), lift.candidates()));
  const TrialPlan plan = plan_lifts(config_, population_.generation());
  const auto lifted = try_again(order, plan, true);
  if (!lifted) return tl::unexpected(lifted.error());
  if (stopped_) return {};
  std::vector<double> share(judgements.size(), 0.0);
  for (std::size_t k = 0; k < order.size(); ++k)
    share[order[k]] = static_cast<double>((*lifted)[k].lifts) / static_cast<double>(plan.trials.size());
  for (std::size_t i = 0; i < judgements.size(); ++i)
    judgements[i].fitness *= 1 - lift.weight() * (1 - share[i]);
  return {};
}

// The best of the validation, on fresh placements.
Status RunLoop::lift_finalists(const std::vector<BestRecord>& finalists,
                               std::vector<ValidationRecord>& records) {
  if (config_.lift().finalists() == 0) return {};
  const TrialPlan plan = plan_final_lifts(config_);
  std::vector<std::size_t> best = ranking(records);
  best.resize(std::min<std::size_t>(best.size(), config_.lift().finalists()));
  std::vector<BestRecord> candidates;
  for (const std::size_t i : best) candidates.push_back(finalists[i]);
  position_.wanted = static_cast<std::uint32_t>(best.size());
  const auto lifted = judge_candidates(candidates, plan, judged_generations_, true);
  if (!lifted) return tl::unexpected(lifted.error());
  if (stopped_) return {};
  for (std::size_t k = 0; k < best.size(); ++k) {
    ValidationRecord& record = records[best[k]];
    record.lift_trials = (*lifted)[k].trials;
    record.lifts = (*lifted)[k].lifts;
    store_.keep_validation(record);
  }
  return {};
}

}  // namespace evograsp::server

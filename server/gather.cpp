#include "server/gather.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/digest.h"
#include "common/log.h"

namespace evograsp::server {

namespace {

std::chrono::steady_clock::time_point after(double seconds) {
  return std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                                std::chrono::duration<double>(seconds));
}

std::string several(std::uint32_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string loss_of(const Poisoned& network) {
  return several(network.workers, "worker") + " on " + several(network.hosts, "host") +
         " died, hung or fell silent with it, in " + std::to_string(network.tries) + " tries";
}

double seconds_of_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void Gather::begin(Kind kind, std::uint32_t generation, std::vector<Item> items,
                   std::vector<proto::TrialKey> trials, std::string stage) {
  const MutexLock lock(mutex_);
  kind_ = kind;
  generation_ = generation;
  items_ = std::move(items);
  keys_ = std::move(trials);
  stage_ = std::move(stage);
  judgements_.assign(items_.size(), {});
  judged_ = 0;
}

Judgement Gather::judge(std::span<const proto::Measurement> measurements) const {
  Judgement judgement;
  judgement.fitness = scorer_.evaluation(measurements);
  for (const proto::Measurement& m : measurements) judgement.scores.push_back(scorer_.trial(m).total);
  judgement.trials = static_cast<std::uint32_t>(measurements.size());
  judgement.successes =
      static_cast<std::uint32_t>(std::count_if(measurements.begin(), measurements.end(), score::success));
  judgement.lifts =
      static_cast<std::uint32_t>(std::count_if(measurements.begin(), measurements.end(), score::held));
  if (map_) judgement.place = map_->place(measurements);
  judgement.judged = true;
  judgement.no_trials = std::all_of(measurements.begin(), measurements.end(),
                                    [](const auto& m) { return m.outcome() == proto::NO_TRIAL; });
  return judgement;
}

void Gather::already(std::uint32_t index, const Judgement& judgement) {
  const MutexLock lock(mutex_);
  judgements_[index] = judgement;
  ++judged_;
}

std::vector<std::uint32_t> Gather::pending() {
  const MutexLock lock(mutex_);
  pending_.clear();
  for (std::uint32_t i = 0; i < judgements_.size(); ++i)
    if (!judgements_[i].judged) pending_.push_back(i);
  return pending_;
}

// A journal entry of one of the dispatcher's networks, without its measurements.
Evaluation Gather::blank(std::uint32_t network) const {
  const MutexLock lock(mutex_);
  Evaluation evaluation;
  evaluation.generation = generation_;
  evaluation.genome = items_[pending_[network]].genome;
  evaluation.stage = stage_;
  return evaluation;
}

// Journalled before it counts: a generation is never committed ahead of its evaluations.
void Gather::evaluated(std::uint32_t network, std::vector<proto::Measurement> measurements) {
  if (kind_ == Kind::kGeneration) {
    Evaluation evaluation = blank(network);
    evaluation.measurements = pack_measurements(measurements);
    store_.journal(std::move(evaluation));
  }
  const Judgement judgement = judge(measurements);
  const MutexLock lock(mutex_);
  trials_ += measurements.size();
  ++evaluations_;
  record(network, judgement);
}

void Gather::record(std::uint32_t network, const Judgement& judgement) {
  const std::uint32_t index = pending_[network];
  if (kind_ == Kind::kValidation) {
    const Item& item = items_[index];
    store_.keep_validation(
        {item.generation, item.genome, judgement.trials, judgement.successes, judgement.fitness});
  }
  judgements_[index] = judgement;
  ++judged_;
}

// Scored zero: its measurements are those of a network that answers nonsense.
void Gather::poisoned(const Poisoned& network) {
  Evaluation evaluation = blank(network.network);
  PoisonRecord poison;
  poison.generation = evaluation.generation;
  poison.genome = evaluation.genome;
  poison.reason = loss_of(network);
  event(true, "poison",
        "genome " + std::to_string(poison.genome) + " of generation " + std::to_string(poison.generation) +
            " is scored zero: " + poison.reason);
  proto::TrialKeys keys;
  for (const proto::TrialKey& key : keys_) *keys.add_trial() = key;
  poison.trials = deterministic_bytes(keys);
  poison.network = network.bytes;
  store_.keep_poison(std::move(poison));
  std::vector<proto::Measurement> nonsense(keys_.size());
  for (proto::Measurement& m : nonsense) m.set_outcome(proto::NOT_A_NUMBER);
  evaluated(network.network, std::move(nonsense));
}

// Forgotten in the journal too, in the order of events: what comes next replaces it.
void Gather::retracted(const std::vector<std::uint32_t>& networks) {
  const MutexLock lock(mutex_);
  std::vector<std::uint64_t> genomes;
  for (const std::uint32_t network : networks) {
    const std::uint32_t index = pending_[network];
    const Item& item = items_[index];
    genomes.push_back(item.genome);
    // A validation without trials is one that a resumed run does not take for done.
    if (kind_ == Kind::kValidation) store_.keep_validation({item.generation, item.genome, 0, 0, 0});
    if (judgements_[index].judged) --judged_;
    judgements_[index] = {};
  }
  evaluations_ -= genomes.size();
  if (kind_ == Kind::kGeneration) store_.forget_evaluations(generation_, stage_, std::move(genomes));
}

void Gather::finished() {
  wake();
}

void Gather::notice(const std::string& text) {
  const MutexLock lock(mutex_);
  if (notice_ != text && notices_.allow(seconds_of_now())) spdlog::warn("a trial cannot be held: {}", text);
  notice_ = text;
}

void Gather::event(bool warning, const std::string& kind, const std::string& text) {
  if (warning)
    spdlog::warn("{}", text);
  else
    spdlog::info("{}", text);
  Event event;
  event.severity = warning ? Severity::kWarning : Severity::kInfo;
  event.kind = kind;
  event.text = text;
  store_.note(std::move(event));
}

void Gather::worker(const PeerView& peer) {
  WorkerRecord record;
  record.identity = peer.identity;
  record.host = peer.host;
  record.build = peer.build;
  record.state = peer.state;
  record.slots = peer.slots;
  record.first_seen = peer.joined;
  record.last_seen = peer.heard;
  record.tasks = peer.tasks;
  record.trials = peer.trials;
  store_.saw_worker(std::move(record));
}

void Gather::broken(const Error& error) {
  {
    const MutexLock lock(mutex_);
    error_ = error;
  }
  wake();
}

void Gather::wake() {
  {
    const MutexLock lock(mutex_);
    woken_ = true;
  }
  changed_.notify_all();
}

bool Gather::wait(double seconds) {
  MutexLock lock(mutex_);
  const auto end = after(seconds);
  while (!woken_ && judged_ != judgements_.size())
    if (!lock.wait_until(changed_, end)) break;
  woken_ = false;
  const bool complete = judged_ == judgements_.size();
  const auto without = [](const Judgement& judgement) { return judgement.no_trials; };
  if (complete && !judgements_.empty() && !error_ &&
      std::all_of(judgements_.begin(), judgements_.end(), without))
    error_ = Error{ErrorCode::kInvalid, "no trial of this generation can be held: " + notice_};
  return complete;
}

void Gather::wait_for_wake(double seconds) {
  MutexLock lock(mutex_);
  const auto end = after(seconds);
  while (!woken_)
    if (!lock.wait_until(changed_, end)) break;
  woken_ = false;
}

std::vector<Judgement> Gather::take() {
  const MutexLock lock(mutex_);
  return std::exchange(judgements_, {});
}

std::uint32_t Gather::judged() const {
  const MutexLock lock(mutex_);
  return judged_;
}

std::uint64_t Gather::trials() const {
  const MutexLock lock(mutex_);
  return trials_;
}

std::uint64_t Gather::evaluations() const {
  const MutexLock lock(mutex_);
  return evaluations_;
}

std::optional<Error> Gather::error() const {
  const MutexLock lock(mutex_);
  return error_;
}

}  // namespace evograsp::server

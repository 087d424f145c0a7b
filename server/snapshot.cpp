#include "server/snapshot.h"

#include <algorithm>
#include <utility>

#include "common/digest.h"
#include "common/version.h"

namespace evograsp::server {

Snapshots::Snapshots(const ResumePoint& start, const std::filesystem::path& run_dir)
    : config_(start.info.config) {
  base_.name = start.info.name;
  base_.build = kVersion;
  base_.fingerprint = start.info.experiment.fingerprint();
  base_.run_dir = run_dir.string();
  base_.run_id = start.info.run_id;
  base_.seed = config_.run().seed();
  base_.epoch = start.epoch;
  base_.started_at = unix_time();
  base_.generations = config_.run().generations();
  last_ = std::make_shared<RunSnapshot>(base_);
}

std::shared_ptr<const RunSnapshot> Snapshots::last() const {
  const MutexLock lock(mutex_);
  return last_;
}

void Snapshots::publish(RunState state, const RunPosition& position,
                        const std::optional<proto::Champion>& champion, const DispatchView& dispatch,
                        const Gather& gather, const StoreFigures& store) {
  auto next = std::make_shared<RunSnapshot>(base_);
  RunSnapshot& s = *next;
  s.state = state;
  s.phase = position.phase;
  s.ready = true;
  s.generation = position.generation;
  s.evaluations_done = position.done;
  s.evaluations_total = position.wanted;
  s.trials = position.trials;
  s.seconds = position.seconds;
  if (position.committed) {
    s.committed = position.committed->generation + 1;
    s.best = position.committed->best;
    s.mean = position.committed->mean;
    s.threshold = position.committed->threshold;
    s.best_ever = position.best_ever;
    s.species = position.species;
  }
  s.counters.trials = gather.trials();
  s.counters.evaluations = gather.evaluations();
  fill_workers(s, dispatch);
  fill_rate(s, position, s.counters.trials);
  fill_champion(s, position, champion);
  s.store = store;
  const MutexLock lock(mutex_);
  last_ = std::move(next);
}

void Snapshots::fill_workers(RunSnapshot& s, const DispatchView& dispatch) {
  const double now = unix_time();
  for (const PeerView& peer : dispatch.workers) {
    WorkerView& worker = s.workers.emplace_back();
    worker.identity = peer.identity;
    worker.host = peer.host;
    worker.build = peer.build;
    worker.state = peer.state;
    worker.slots = peer.slots;
    worker.busy = std::min(peer.slots, peer.outstanding);
    worker.tasks = peer.tasks;
    worker.trials = peer.trials;
    worker.trials_per_second =
        peer.busy_seconds > 0 ? static_cast<double>(peer.trials) / peer.busy_seconds * peer.slots : 0;
    worker.silent_seconds = std::max(0.0, now - peer.heard);
    worker.round_trip_seconds = peer.round_trip;
    worker.trial_seconds = peer.trial_seconds;
  }
  s.slots_wanted = dispatch.slots_wanted;
  RunCounters& c = s.counters;
  c.tasks_sent = dispatch.scheduler.tasks;
  c.tasks_done = dispatch.tasks_done;
  c.tasks_requeued = dispatch.scheduler.requeued;
  c.tasks_speculated = dispatch.scheduler.speculated;
  c.results_late = dispatch.scheduler.late;
  c.frames_refused = dispatch.malformed;
  c.hellos_refused = dispatch.refused;
  c.workers_lost = dispatch.lost;
  c.audits = dispatch.audits;
  c.audit_mismatches = dispatch.audit_mismatches;
  c.workers_quarantined = dispatch.quarantined;
  c.genomes_poisoned = dispatch.poisoned;
  c.bytes_sent = dispatch.bytes_sent;
  c.bytes_received = dispatch.bytes_received;
}

void Snapshots::fill_rate(RunSnapshot& s, const RunPosition& position, std::uint64_t trials) {
  const double now = unix_time();
  if (last_time_ > 0 && now - last_time_ > 0.05) {
    const double lately = static_cast<double>(trials - last_trials_) / (now - last_time_);
    rate_ = rate_ > 0 ? rate_ + 0.3 * (lately - rate_) : lately;
  }
  if (last_time_ == 0 || now - last_time_ > 0.05) {
    last_time_ = now;
    last_trials_ = trials;
  }
  s.trials_per_second = rate_;
  if (s.committed == 0 || rate_ <= 0 || position.phase != "evolving") return;
  const double each = static_cast<double>(position.committed->trials) / static_cast<double>(s.committed);
  s.seconds_left =
      each * static_cast<double>(s.generations - std::min<std::uint64_t>(s.committed, s.generations)) / rate_;
}

void Snapshots::fill_champion(RunSnapshot& s, const RunPosition& position,
                              const std::optional<proto::Champion>& champion) {
  if (champion && !chosen_) {
    best_ = std::make_shared<const std::string>(deterministic_bytes(*champion));
    chosen_ = true;
  } else if (!chosen_ && position.best && (!best_ || position.best->generation != best_generation_)) {
    const auto made = make_champion(config_, base_.fingerprint, *position.best, {});
    if (made) best_ = std::make_shared<const std::string>(deterministic_bytes(*made));
    best_generation_ = position.best->generation;
  }
  s.champion = best_;
  s.champion_chosen = chosen_;
}

}  // namespace evograsp::server

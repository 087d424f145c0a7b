// What the outside may see of a living run and ask of it. The HTTP API speaks to this interface alone.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "neat/population.h"
#include "server/server.h"
#include "server/store.h"

namespace evograsp::server {

// A worker as the dispatcher sees it now.
struct WorkerView {
  std::string identity, host, build;
  std::string state;  // active, draining, quarantined, gone
  std::uint32_t slots = 0, busy = 0;
  std::uint64_t tasks = 0, trials = 0;               // accepted from it, in this process
  double trials_per_second = 0;                      // lately
  double silent_seconds = 0;                         // since its last frame, at the time of the snapshot
  double round_trip_seconds = 0, trial_seconds = 0;  // 0: not measured
};

// What has happened since this process started. Only ever grows.
struct RunCounters {
  std::uint64_t evaluations = 0, trials = 0;
  std::uint64_t tasks_sent = 0, tasks_done = 0, tasks_requeued = 0, tasks_speculated = 0;
  std::uint64_t results_late = 0;       // of an earlier attempt, epoch or generation: ignored
  std::uint64_t results_duplicate = 0;  // a copy was faster
  std::uint64_t frames_refused = 0;     // did not parse, too large, out of order
  std::uint64_t hellos_refused = 0;     // version, fingerprint or identity
  std::uint64_t workers_lost = 0;
  std::uint64_t audits = 0, audit_mismatches = 0;
  std::uint64_t workers_quarantined = 0;
  std::uint64_t genomes_poisoned = 0;
  std::uint64_t bytes_sent = 0, bytes_received = 0;
};

// One moment of a run. Immutable once published: readers share it, the run goes on.
struct RunSnapshot {
  std::string name, build, fingerprint, run_dir;
  std::uint64_t run_id = 0, seed = 0, epoch = 0;
  double started_at = 0;  // Unix time of this process's start, s
  RunState state = RunState::kRunning;
  std::string phase;   // evolving, validating, done
  bool ready = false;  // accepts workers and answers

  std::uint32_t generation = 0, generations = 0;              // being evaluated; to be evaluated in all
  std::uint64_t evaluations_done = 0, evaluations_total = 0;  // of this generation (or of the validation)
  std::uint64_t trials = 0;                                   // of the run so far
  double seconds = 0;            // wall time of the run so far, resumed parts included
  double trials_per_second = 0;  // lately
  double seconds_left = -1;      // estimate; negative: unknown

  // Of the last committed generation (generation - 1); meaningless while committed is 0.
  std::uint64_t committed = 0;  // generations
  double best = 0, mean = 0, threshold = 0;
  double best_ever = 0;
  std::vector<neat::SpeciesSummary> species;

  std::vector<WorkerView> workers;
  std::uint64_t slots_wanted = 0;  // that the run could use (server/slot_hint.h); 0: not known yet
  RunCounters counters;
  StoreFigures store;

  // The chosen champion, or the best so far (validation_trials 0): serialised deterministically; null: none
  // yet.
  std::shared_ptr<const std::string> champion;
  bool champion_chosen = false;
  std::string error;  // why the run failed; empty otherwise
};

// Implemented by the run. Every method may be called from any thread at any time and returns soon.
class RunControl {
 public:
  virtual ~RunControl() = default;
  // Never null, never waits for the run: the last published moment.
  virtual std::shared_ptr<const RunSnapshot> snapshot() const = 0;
  // Pausing lets the tasks in flight finish and sends no more. kInvalid when the run has ended.
  virtual Status pause() = 0;
  virtual Status resume() = 0;
  // Workers of a host, or the one of that identity, get no more work, or get work again; also those that join
  // later, until this process ends. Gives how many are here now; kNotFound: none.
  virtual Result<std::uint32_t> drain(const std::string& node, bool drained) = 0;
  // Commits what there is and ends the run.
  virtual Status stop() = 0;
  // Waits (at most a few seconds) until all finished work is on the disk.
  virtual Status checkpoint() = 0;
  // One of trace, debug, info, warn, error, off.
  virtual std::string log_level() const = 0;
  virtual Status set_log_level(const std::string& level) = 0;
};

}  // namespace evograsp::server

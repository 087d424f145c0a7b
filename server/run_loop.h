// Evolution from one committed generation to the next, and the choice of the champion at the end.
//
//   ask -> plan trials -> dispatch -> gather -> tell -> dispatch the next -> commit (on the store's thread)
//   -> announce
//
// The next generation is evaluated while the last is being committed; it is announced only after that. A
// crash in between costs nothing: the evaluations of the last are journalled before it is committed, and
// those of the next are journalled under its own number. Everything is a function of the config and the run's
// seed: neither the order in which results arrive, nor how often the run was interrupted, changes a byte of
// what comes out.
#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "common/mutex.h"
#include "neat/express.h"
#include "neat/population.h"
#include "server/dispatcher.h"
#include "server/gather.h"
#include "server/server.h"
#include "server/store.h"
#include "server/trial_plan.h"

namespace evograsp::server {

// Not finite is worse than everything; evolution must never breed from it.
inline double rank_value(double fitness) {
  return std::isfinite(fitness) ? fitness : -HUGE_VAL;
}

// Where the loop stands, for snapshots.
struct RunPosition {
  std::string phase = "evolving";  // then "validating", "done"
  std::uint32_t generation = 0;    // being evaluated
  std::uint32_t wanted = 0;        // evaluations of this generation or of the validation
  std::uint32_t done = 0;
  std::optional<GenerationRecord> committed;  // the last one
  std::vector<neat::SpeciesSummary> species;  // of it
  double best_ever = 0;
  std::optional<BestRecord> best;           // of all committed generations, by training fitness
  std::optional<proto::Champion> champion;  // chosen
  std::uint64_t trials = 0;
  double seconds = 0;
};

// One thread runs run(); pause, resume, stop and wake may be called from any.
class RunLoop {
 public:
  struct Callbacks {
    std::function<void(const GenerationReport&)> generation;  // after its commit; on run()'s thread
    std::function<void()> progress;                           // some times a second; on run()'s thread
  };

  RunLoop(const ResumePoint& start, neat::Population population, Store& store, Dispatcher& dispatcher,
          Gather& gather, Callbacks callbacks);

  Result<RunState> run();
  void set_paused(bool paused);
  void stop();
  bool paused() const { return paused_; }

  // On run()'s thread, or when it is not running.
  const RunPosition& position() const { return position_; }

 private:
  struct Committed {
    GenerationRecord record;
    BestRecord best;
    std::vector<neat::SpeciesSummary> species;
    Status status;
    std::vector<EliteRecord> elites = {};
    std::vector<std::uint32_t> emptied = {};
  };

  // Of optional trials, journalled: generation, stage, genome -> measurements.
  using Journalled = std::map<std::tuple<std::uint32_t, std::string, std::uint64_t>, std::string>;

  bool evolved() const;
  Status evolve_one(bool resumed);
  Status hand_out(const std::vector<std::uint32_t>& pending, Work work);
  void take_journalled();
  void judge_generation(const TrialPlan& plan, const std::vector<Judgement>& judgements);
  std::string network_bytes(const neat::Genome& genome);  // serialised proto::Network
  BestRecord best_of(const std::vector<double>& fitness);
  void describe_elites(Committed& entry);
  GenerationRecord describe(const std::vector<double>& fitness) const;
  void commit_judged();
  Result<std::vector<Judgement>> try_again(const std::vector<std::uint32_t>& genomes, const TrialPlan& plan,
                                           bool lifts);
  Result<std::vector<Judgement>> judge_candidates(const std::vector<BestRecord>& candidates,
                                                  const TrialPlan& plan, std::uint32_t generation,
                                                  bool lifts);
  void take_journalled_optional(const std::vector<BestRecord>& candidates, const TrialPlan& plan,
                                std::uint32_t generation);
  void warn_of_time();
  bool round_is_due(std::uint32_t round, std::optional<std::uint32_t> decided) const;
  Status race(std::vector<Judgement>& judgements);
  Status lift_best(std::vector<Judgement>& judgements);
  Status validate();
  Status lift_finalists(const std::vector<BestRecord>& finalists, std::vector<ValidationRecord>& records);
  Status publish_champion(const BestRecord& best, const ValidationRecord& validation);

  // Waits for the work that is out; answers to pause and stop meanwhile. An empty status and stopped_:
  // interrupted.
  Status wait_for_work();
  Status wait_for_commits(std::size_t most);
  Status announce();
  Status health() const;
  void follow_pause();
  double seconds() const;

  const proto::Config config_;
  const std::string fingerprint_;
  Store& store_;
  Dispatcher& dispatcher_;
  Gather& gather_;
  Callbacks callbacks_;

  neat::Population population_;
  neat::Expressor expressor_;
  std::vector<Evaluation> journalled_;  // of the generation that was interrupted
  Journalled journalled_optional_;
  std::optional<std::uint32_t> decided_rounds_;  // of its race
  std::chrono::steady_clock::time_point generation_start_{};
  std::vector<ValidationRecord> validated_;  // before the interruption
  std::deque<BestRecord> bests_;             // of the last champion.candidates generations
  std::optional<Committed> judged_;          // to be committed
  double last_best_ = 0;
  std::uint32_t judged_generations_ = 0;
  double seconds_before_ = 0;
  std::uint64_t trials_ = 0, evaluations_ = 0;  // judged
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point next_progress_{};
  RunPosition position_;
  bool pause_followed_ = false;

  std::atomic<bool> paused_{false}, stopped_{false};

  Mutex mutex_;
  std::deque<Committed> committed_ GUARDED_BY(mutex_);  // waiting to be announced
  std::size_t committing_ GUARDED_BY(mutex_) = 0;       // handed to the store, not announced
};

}  // namespace evograsp::server

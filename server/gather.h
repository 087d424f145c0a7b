// Between the dispatcher's thread, which brings results, and the run loop, which waits for them.
//
// Results are scored and journalled as they arrive, each network's trials in trial order; what comes out does
// not depend on the order of arrival.
#pragma once

#include <condition_variable>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/log.h"
#include "common/mutex.h"
#include "score/grasp_measure.h"
#include "score/score.h"
#include "server/store.h"
#include "server/work.h"

namespace evograsp::server {

// What the workers made of a network.
struct Judgement {
  double fitness = 0;
  std::uint32_t trials = 0, successes = 0;
  bool judged = false;
  std::uint32_t lifts = 0;        // that held
  std::vector<double> scores;     // fitness of each trial
  std::array<double, 2> place{};  // on the map of grasps, if there is one
  bool no_trials = false;         // none could be held
};

// Thread-safe.
class Gather : public WorkSink {
 public:
  // map: of runs with an archive.
  Gather(const score::Scorer& scorer, Store& store, std::optional<score::GraspMap> map = {})
      : scorer_(scorer), store_(store), map_(map) {}

  enum class Kind { kGeneration, kValidation };  // kept: measurements, judgements
  struct Item {
    std::uint64_t genome = 0;
    std::uint32_t generation = 0;  // that bred it
  };
  // Before new work: forgets the old. trials: the plan's; stage: of optional ones (Evaluation.stage).
  void begin(Kind kind, std::uint32_t generation, std::vector<Item> items,
             std::vector<proto::TrialKey> trials, std::string stage = {});
  // Work that need not be done again; the same as evaluated(), without a journal entry.
  void already(std::uint32_t index, const Judgement& judgement);
  Judgement judge(std::span<const proto::Measurement> measurements) const;
  // Items still to be judged. From now on the dispatcher's network i is pending()[i].
  std::vector<std::uint32_t> pending();

  // Wakes wait() for any other reason.
  void wake();
  // Returns when everything is judged, when woken, or after `seconds`; true when everything is judged.
  bool wait(double seconds);
  // The same without looking at the work.
  void wait_for_wake(double seconds);
  std::vector<Judgement> take();
  std::uint32_t judged() const;
  std::uint64_t trials() const;  // simulated for this process's work, all kinds
  std::uint64_t evaluations() const;
  // Why the run cannot go on.
  std::optional<Error> error() const;

  void evaluated(std::uint32_t index, std::vector<proto::Measurement> measurements) override;
  void poisoned(const Poisoned& network) override;
  void retracted(const std::vector<std::uint32_t>& networks) override;
  void finished() override;
  void notice(const std::string& text) override;
  void event(bool warning, const std::string& kind, const std::string& text) override;
  void worker(const PeerView& worker) override;
  void broken(const Error& error) override;

 private:
  Evaluation blank(std::uint32_t network) const;
  void record(std::uint32_t network, const Judgement& judgement) REQUIRES(mutex_);

  const score::Scorer& scorer_;
  Store& store_;
  const std::optional<score::GraspMap> map_;

  // What the work is. Written while no work is out; then both threads only read it.
  Kind kind_ = Kind::kGeneration;
  std::uint32_t generation_ = 0;
  std::string stage_;
  std::vector<Item> items_;
  std::vector<std::uint32_t> pending_;  // item of each of the dispatcher's networks
  std::vector<proto::TrialKey> keys_;

  mutable Mutex mutex_;
  std::condition_variable changed_;
  std::vector<Judgement> judgements_ GUARDED_BY(mutex_);
  std::uint32_t judged_ GUARDED_BY(mutex_) = 0;
  std::uint64_t trials_ GUARDED_BY(mutex_) = 0, evaluations_ GUARDED_BY(mutex_) = 0;
  std::string notice_ GUARDED_BY(mutex_);
  LogLimiter notices_ GUARDED_BY(mutex_){10, 1.0};
  std::optional<Error> error_ GUARDED_BY(mutex_);
  bool woken_ GUARDED_BY(mutex_) = false;
};

}  // namespace evograsp::server

// run.db: everything a run must not lose, in one SQLite file (WAL). See docs/STORE.md for the tables.
//
// Promises:
// - commit_generation() is atomic and, once its callback has said so, on the disk (full sync). Kill -9 or
// power loss
//   at any instant leaves the last committed generation; kill -9 loses at most the work of the last
//   store.journal_seconds.
// - Generations that follow each other faster than that share a transaction, and only what is still wanted
// after the
//   last of them is written: small generations would otherwise cost more to store than to evaluate.
// - A damaged row is noticed by its seal; a damaged population falls back to the one before it, with a
// warning.
// - Errors stick: after the first failed write nothing more is written but the state "failed" and an event
// that
//   says why, if the disk takes them; status() says what happened, and what was committed before stays
//   readable.
// - Events and workers, which strangers can cause any number of, are bounded: 10,000 of each, in memory and
// in
//   the file. What comes faster is left out.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "server/store_records.h"

namespace evograsp::server {

struct NewRun {
  RunInfo info;  // created_at is set by the store
  std::vector<StoredAsset> assets;
  std::string population;  // neat::Population::save() of generation 0
};

// Where a run goes on.
struct ResumePoint {
  RunInfo info;
  std::vector<StoredAsset> assets;
  std::uint64_t epoch = 0;  // of this start: one more than any before
  std::string state;  // as the last server left it: running (it died), paused, finished, stopped, failed
  std::uint32_t generation = 0;           // the population's: the one to evaluate next
  std::string population;                 // neat::Population::load takes it
  std::vector<Evaluation> evaluations;    // of `generation`, by genome id: work that need not be done again
  std::vector<Evaluation> optional;       // of its optional trials, by stage and genome id
  std::optional<std::uint32_t> rounds;    // of its race, when time had decided that
  std::vector<GenerationRecord> history;  // the judged generations, in order
  std::vector<BestRecord> bests;          // of the last champion.candidates generations, in order
  std::vector<ValidationRecord> validations;
  std::string champion;               // serialised; empty until one has been chosen
  std::vector<std::string> warnings;  // what had to be left behind, for the log
};

struct StoreFigures {
  std::uint64_t evaluations = 0;   // journalled since the start of this process
  std::uint64_t transactions = 0;  // all kinds
  std::uint64_t queued_bytes = 0;  // waiting for the writer now
  double last_commit_seconds = 0;  // of a generation, sync included
  double total_commit_seconds = 0;
  std::uint64_t commits = 0;     // generations
  std::uint64_t file_bytes = 0;  // run.db without its log
};

// The one writer of a run. Every method may be called from any thread. Everything but flush() and the
// factories returns at once: a thread of the store's own writes, in the order of the calls; workers last.
// What brings bytes (journal(), keep_poison(), commit_generation()) may wait, when 256 MiB are queued.
class Store {
 public:
  using Callback = std::function<void(const Status&)>;  // called on the store's thread; must not block

  // Whether there is a run to resume: --continue asks.
  static bool holds_run(const std::filesystem::path& run_dir);
  // A new run in run_dir (made when missing). kInvalid when there is a run already.
  static Result<std::unique_ptr<Store>> create(const std::filesystem::path& run_dir, NewRun run);
  struct Resumed {
    std::unique_ptr<Store> store;
    ResumePoint point;
  };
  // kNotFound without a run; kUnavailable while another server has it; kInvalid when it is damaged beyond
  // falling back; kUnsupported for a newer schema.
  static Result<Resumed> resume(const std::filesystem::path& run_dir);

  // Writes what is queued, folds the log into run.db and lets the run go.
  virtual ~Store() = default;

  virtual void journal(Evaluation evaluation) = 0;
  // May take up to store.journal_seconds (0.1 s at most) until hurry() is called.
  virtual void commit_generation(GenerationCommit commit, Callback done) = 0;
  // Somebody waits for what has been queued: write it now.
  virtual void hurry() = 0;
  virtual void note(Event event) = 0;
  virtual void saw_worker(WorkerRecord worker) = 0;
  virtual void keep_poison(PoisonRecord poison) = 0;
  virtual void keep_validation(ValidationRecord validation) = 0;
  // Full sync, like a generation.
  virtual void keep_champion(const proto::Champion& champion, Callback done) = 0;
  virtual void set_state(std::string state, Callback done = {}) = 0;

  // Drops the journalled evaluations of these genomes: a worker that lied did them.
  virtual void forget_evaluations(std::uint32_t generation, std::string stage,
                                  std::vector<std::uint64_t> genomes) = 0;
  // How many rounds a generation's race had, where time decided that: before anything that follows from it.
  virtual void keep_race(std::uint32_t generation, std::uint32_t rounds) = 0;

  // Waits until everything queued so far is on the disk (full sync).
  virtual Status flush() = 0;
  // The first error, if there was one. The run must stop with it.
  virtual Status status() const = 0;
  virtual StoreFigures figures() const = 0;
};

inline constexpr char kStoreFile[] = "run.db";

}  // namespace evograsp::server

// Reading a run.db beside a living server, or after it: one read-only connection. Reads see committed states
// only and never hold up the writer.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/mutex.h"
#include "common/result.h"
#include "server/store_records.h"
#include "server/store_sqlite.h"

namespace evograsp::server {

// Thread-safe: calls take turns.
class StoreReader {
 public:
  // kNotFound without a run.db, kUnsupported for another schema, kInvalid for a file that is no run.
  static Result<std::unique_ptr<StoreReader>> open(const std::filesystem::path& run_dir);

  // Reads through a connection that the caller keeps open and does not use meanwhile.
  explicit StoreReader(Database* borrowed) : database_(borrowed) {}

  Result<RunInfo> run();
  Result<RunProgress> progress();
  Result<std::vector<StoredAsset>> assets();
  // Judged generations from `from` on, at most `limit`, in order.
  Result<std::vector<GenerationRecord>> generations(std::uint32_t from, std::uint32_t limit);
  Result<std::optional<GenerationRecord>> last_generation();
  Result<std::vector<neat::SpeciesSummary>> species(std::uint32_t generation);
  // Events with id > since, oldest first; the last `limit` of them when since is 0.
  Result<std::vector<Event>> events(std::int64_t since, std::uint32_t limit);
  Result<std::vector<WorkerRecord>> workers();
  // Bests of generations from `from` on, in order.
  Result<std::vector<BestRecord>> bests(std::uint32_t from, std::uint32_t limit);
  // The best genome of the whole run by its training fitness (the earliest of equals).
  Result<std::optional<BestRecord>> best();
  Result<std::vector<ValidationRecord>> validations();
  Result<std::vector<PoisonRecord>> poisons();
  Result<std::vector<Evaluation>> evaluations(std::uint32_t generation);
  // Of the generation's optional trials, by stage and genome.
  Result<std::vector<Evaluation>> optional_evaluations(std::uint32_t generation);
  // Rounds of the generation's race, where race.budget_seconds decided.
  Result<std::optional<std::uint32_t>> race_rounds(std::uint32_t generation);
  Result<std::vector<EliteRecord>> elites();  // by cell
  // Serialised proto::Champion; empty until the run has chosen one.
  Result<std::string> champion();
  // Population::save() of the generation to be evaluated next, or another one still kept.
  struct PopulationState {
    std::uint32_t generation = 0;
    std::string state;
  };
  Result<std::vector<std::uint32_t>> populations();  // generations kept, ascending
  Result<PopulationState> population(std::uint32_t generation);

 private:
  explicit StoreReader(std::unique_ptr<Database> owned) : owned_(std::move(owned)), database_(owned_.get()) {}

  // Files of the schema before lack some.
  bool has_table(const char* name) REQUIRES(mutex_);

  Mutex mutex_;
  std::unique_ptr<Database> owned_;
  Database* const database_ PT_GUARDED_BY(mutex_);
};

// Whether a server has the run open now.
bool is_live(const std::filesystem::path& run_dir);

}  // namespace evograsp::server

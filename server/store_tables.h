// The writing half of run.db: one method a change, inside whatever transaction is open. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "server/store.h"
#include "server/store_sqlite.h"

namespace evograsp::server {

// What is kept of the past (proto::StoreConfig).
struct Retention {
  // The newest ones; never under 2: the second is what a damaged last falls back to.
  std::uint32_t populations = 2;
  // Each generation's; else only the last one's of each transaction.
  bool every_generation = false;
  bool all_evaluations = false;   // else those of the last judged generation and of the one in progress
  std::uint32_t events = 10000;   // the newest ones
  std::uint32_t workers = 10000;  // those that are here, then those that did something, then the newest ones
  static Retention from(const proto::StoreConfig& config);
  // Whether the population bred from `generation` is written by a transaction whose last one is `newest`.
  bool wants_population(std::uint32_t generation, std::uint32_t newest) const;
};

class StoreTables {
 public:
  static Result<StoreTables> prepare(Database& database);

  Status put_run(const RunInfo& info, double now);
  Status put_asset(const StoredAsset& asset);
  Status put_progress(const RunProgress& progress);
  Status put_population(std::uint32_t generation, std::string_view state);
  Status put_evaluation(const Evaluation& evaluation);
  // newest: the generation that the same transaction commits last, if any. Of those before it only what will
  // be kept is written.
  Status put_generation(const GenerationCommit& commit, double now, const Retention& retention,
                        std::optional<std::uint32_t> newest = {});
  Status put_race(std::uint32_t generation, std::uint32_t rounds);
  Status put_event(const Event& event, double now, const Retention& retention);
  Status put_workers(const std::vector<WorkerRecord>& workers, const Retention& retention);
  Status put_poison(const PoisonRecord& poison);
  Status put_validation(const ValidationRecord& validation);
  Status put_champion(const std::string& champion);
  Status forget_evaluations(std::uint32_t generation, const std::string& stage,
                            const std::vector<std::uint64_t>& genomes);
  // Changes nothing, but makes the transaction around it one that writes, so that its commit syncs.
  Status touch() { return database_->exec("UPDATE progress SET id = id"); }
  // Undoes the judging of `generation` and of all after it.
  Status roll_back_to(std::uint32_t generation);

 private:
  explicit StoreTables(Database& database) : database_(&database) {}
  Status put_elites(const GenerationCommit& commit);
  Status put_worker(const WorkerRecord& worker);
  Status prune(std::uint32_t generation, const Retention& retention);

  Database* database_;
  // The hot ones are prepared once.
  std::optional<Statement> evaluation_, optional_, species_;
};

}  // namespace evograsp::server

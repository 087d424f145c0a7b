#include "server/store_tables.h"

#include <google/protobuf/text_format.h>

#include <algorithm>

#include "common/digest.h"

namespace evograsp::server {
namespace {

template <class Bind>
Status write(Database& database, std::string_view sql, Bind bind) {
  auto statement = database.prepare(sql);
  if (!statement) return tl::unexpected<Error>(statement.error());
  bind(*statement);
  return statement->run();
}

std::int64_t signed_of(std::uint64_t value) {
  return static_cast<std::int64_t>(value);
}

}  // namespace

Retention Retention::from(const proto::StoreConfig& config) {
  Retention r;
  r.populations = std::max(2u, config.keep_generations());
  r.every_generation = config.keep_generations() > 0;
  r.all_evaluations = config.journal_trials();
  return r;
}

bool Retention::wants_population(std::uint32_t generation, std::uint32_t newest) const {
  return generation == newest || (every_generation && generation + populations > newest);
}

Result<StoreTables> StoreTables::prepare(Database& database) {
  StoreTables tables(database);
  auto evaluation = database.prepare("INSERT OR REPLACE INTO evaluations VALUES (?,?,?,?)");
  if (!evaluation) return tl::unexpected<Error>(evaluation.error());
  tables.evaluation_ = std::move(*evaluation);
  auto optional = database.prepare("INSERT OR REPLACE INTO optional_evaluations VALUES (?,?,?,?,?)");
  if (!optional) return tl::unexpected<Error>(optional.error());
  tables.optional_ = std::move(*optional);
  auto species = database.prepare("INSERT OR REPLACE INTO species VALUES (?,?,?,?,?,?,?,?)");
  if (!species) return tl::unexpected<Error>(species.error());
  tables.species_ = std::move(*species);
  return tables;
}

Status StoreTables::put_run(const RunInfo& info, double now) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(info.config, &text);
  const std::string config = deterministic_bytes(info.config);
  const std::string experiment = deterministic_bytes(info.experiment);
  return write(*database_, "INSERT INTO run VALUES (?,?,?,?,?,?,?,?,?,?,?)", [&](Statement& s) {
    s.bind(std::int64_t{1}).bind_id(info.run_id).bind_text(info.name).bind_id(info.config.run().seed());
    s.bind_text(info.experiment.fingerprint()).bind_text(info.build).bind(now).bind_text(text);
    s.bind_blob(config).bind_blob(experiment).bind_seal();
  });
}

Status StoreTables::put_asset(const StoredAsset& asset) {
  return write(*database_, "INSERT OR REPLACE INTO assets VALUES (?,?,?,?,?)", [&](Statement& s) {
    s.bind_text(asset.id).bind_text(asset.kind).bind_text(asset.name).bind_blob(asset.packed).bind_seal();
  });
}

Status StoreTables::put_progress(const RunProgress& progress) {
  return write(*database_, "INSERT OR REPLACE INTO progress VALUES (?,?,?,?,?)", [&](Statement& s) {
    s.bind(std::int64_t{1})
        .bind_id(progress.epoch)
        .bind_text(progress.state)
        .bind(progress.updated_at)
        .bind_seal();
  });
}

Status StoreTables::put_population(std::uint32_t generation, std::string_view state) {
  return write(*database_, "INSERT OR REPLACE INTO populations VALUES (?,?,?)",
               [&](Statement& s) { s.bind(std::int64_t{generation}).bind_blob(state).bind_seal(); });
}

Status StoreTables::put_evaluation(const Evaluation& evaluation) {
  if (!evaluation.stage.empty()) {
    optional_->bind(std::int64_t{evaluation.generation}).bind_text(evaluation.stage);
    optional_->bind_id(evaluation.genome).bind_blob(evaluation.measurements).bind_seal();
    return optional_->run();
  }
  evaluation_->bind(std::int64_t{evaluation.generation}).bind_id(evaluation.genome);
  evaluation_->bind_blob(evaluation.measurements).bind_seal();
  return evaluation_->run();
}

Status StoreTables::put_generation(const GenerationCommit& commit, double now, const Retention& retention,
                                   std::optional<std::uint32_t> newest) {
  const GenerationRecord& r = commit.record;
  Status done =
      write(*database_, "INSERT INTO generations VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)", [&](Statement& s) {
        s.bind(std::int64_t{r.generation})
            .bind(r.best)
            .bind(r.mean)
            .bind(r.deviation)
            .bind(std::int64_t{r.species});
        s.bind(r.threshold).bind_id(r.best_genome).bind(r.links).bind_id(r.evaluations).bind_id(r.trials);
        s.bind(r.seconds).bind(now).bind_seal();
      });
  for (const neat::SpeciesSummary& one : commit.species) {
    if (!done) return done;
    species_->bind(std::int64_t{r.generation}).bind(std::int64_t{one.id}).bind(std::int64_t{one.age});
    species_->bind(std::int64_t{one.last_improved}).bind(std::int64_t{one.size});
    species_->bind(one.best).bind(one.mean).bind_seal();
    done = species_->run();
  }
  if (!done) return done;
  const BestRecord& b = commit.best;
  done = write(*database_, "INSERT INTO bests VALUES (?,?,?,?,?,?)", [&](Statement& s) {
    s.bind(std::int64_t{b.generation}).bind_id(b.genome).bind(b.fitness);
    s.bind_blob(b.genotype).bind_blob(b.network).bind_seal();
  });
  if (done) done = put_elites(commit);
  const std::uint32_t last = newest.value_or(r.generation);
  if (done && retention.wants_population(r.generation, last))
    done = put_population(r.generation + 1, commit.population);
  if (done && r.generation == last) done = prune(r.generation, retention);
  return done;
}

Status StoreTables::put_elites(const GenerationCommit& commit) {
  Status done;
  for (const EliteRecord& e : commit.elites) {
    if (!done) return done;
    done = write(*database_, "INSERT OR REPLACE INTO elites VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)",
                 [&](Statement& s) {
                   s.bind(std::int64_t{e.cell}).bind(std::int64_t{e.x}).bind(std::int64_t{e.y});
                   s.bind(e.x_value).bind(e.y_value).bind(e.fitness).bind(std::int64_t{e.judged});
                   s.bind_id(e.genome).bind(std::int64_t{e.generation}).bind(std::int64_t{e.updated});
                   s.bind_blob(e.genotype).bind_blob(e.network).bind_seal();
                 });
  }
  for (const std::uint32_t cell : commit.emptied) {
    if (!done) return done;
    done = write(*database_, "DELETE FROM elites WHERE cell = ?",
                 [&](Statement& s) { s.bind(std::int64_t{cell}); });
  }
  return done;
}

Status StoreTables::put_race(std::uint32_t generation, std::uint32_t rounds) {
  return write(*database_, "INSERT OR REPLACE INTO races VALUES (?,?,?)", [&](Statement& s) {
    s.bind(std::int64_t{generation}).bind(std::int64_t{rounds}).bind_seal();
  });
}

Status StoreTables::prune(std::uint32_t generation, const Retention& retention) {
  Status done = write(*database_,
                      "DELETE FROM populations WHERE generation NOT IN "
                      "(SELECT generation FROM populations ORDER BY generation DESC LIMIT ?)",
                      [&](Statement& s) { s.bind(std::int64_t{retention.populations}); });
  for (const char* table : {"evaluations", "optional_evaluations"})
    if (done && !retention.all_evaluations)
      done = write(*database_, std::string("DELETE FROM ") + table + " WHERE generation < ?",
                   [&](Statement& s) { s.bind(std::int64_t{generation}); });
  return done;
}

Status StoreTables::put_event(const Event& event, double now, const Retention& retention) {
  // The number is part of the sealed row, so it is chosen here and not by the insert.
  const auto last = database_->integer("SELECT coalesce(max(id), 0) FROM events");
  if (!last) return tl::unexpected<Error>(last.error());
  const Status done = write(*database_, "INSERT INTO events VALUES (?,?,?,?,?,?)", [&](Statement& s) {
    s.bind(*last + 1).bind(event.time > 0 ? event.time : now).bind(static_cast<std::int64_t>(event.severity));
    s.bind_text(event.kind).bind_text(event.text).bind_seal();
  });
  if (!done) return done;
  return write(*database_, "DELETE FROM events WHERE id <= ?",
               [&](Statement& s) { s.bind(*last + 1 - std::int64_t{retention.events}); });
}

Status StoreTables::put_workers(const std::vector<WorkerRecord>& workers, const Retention& retention) {
  for (const WorkerRecord& worker : workers)
    if (const Status done = put_worker(worker); !done) return done;
  const auto count = database_->integer("SELECT count(*) FROM workers");
  if (!count) return tl::unexpected<Error>(count.error());
  if (*count <= std::int64_t{retention.workers}) return {};
  return write(*database_,
               "DELETE FROM workers WHERE identity NOT IN (SELECT identity FROM workers "
               "ORDER BY state = 'gone', trials = 0, last_seen DESC, identity LIMIT ?)",
               [&](Statement& s) { s.bind(std::int64_t{retention.workers}); });
}

Status StoreTables::put_worker(const WorkerRecord& w) {
  return write(*database_, "INSERT OR REPLACE INTO workers VALUES (?,?,?,?,?,?,?,?,?,?)", [&](Statement& s) {
    s.bind_text(w.identity)
        .bind_text(w.host)
        .bind_text(w.build)
        .bind_text(w.state)
        .bind(std::int64_t{w.slots});
    s.bind(w.first_seen).bind(w.last_seen).bind(signed_of(w.tasks)).bind(signed_of(w.trials)).bind_seal();
  });
}

Status StoreTables::put_poison(const PoisonRecord& p) {
  return write(*database_, "INSERT OR REPLACE INTO poisons VALUES (?,?,?,?,?,?)", [&](Statement& s) {
    s.bind(std::int64_t{p.generation}).bind_id(p.genome).bind_text(p.reason);
    s.bind_blob(p.network).bind_blob(p.trials).bind_seal();
  });
}

Status StoreTables::put_validation(const ValidationRecord& v) {
  return write(*database_, "INSERT OR REPLACE INTO validations VALUES (?,?,?,?,?,?,?,?)", [&](Statement& s) {
    s.bind(std::int64_t{v.generation}).bind_id(v.genome).bind(std::int64_t{v.trials});
    s.bind(std::int64_t{v.successes}).bind(v.fitness);
    s.bind(std::int64_t{v.lift_trials}).bind(std::int64_t{v.lifts}).bind_seal();
  });
}

Status StoreTables::put_champion(const std::string& champion) {
  return write(*database_, "INSERT OR REPLACE INTO champion VALUES (?,?,?)",
               [&](Statement& s) { s.bind(std::int64_t{1}).bind_blob(champion).bind_seal(); });
}

Status StoreTables::forget_evaluations(std::uint32_t generation, const std::string& stage,
                                       const std::vector<std::uint64_t>& genomes) {
  auto statement = database_->prepare(
      stage.empty() ? "DELETE FROM evaluations WHERE generation = ? AND genome = ?"
                    : "DELETE FROM optional_evaluations WHERE generation = ? AND genome = ? AND stage = ?");
  if (!statement) return tl::unexpected<Error>(statement.error());
  for (const std::uint64_t genome : genomes) {
    statement->bind(std::int64_t{generation}).bind_id(genome);
    if (!stage.empty()) statement->bind_text(stage);
    if (const Status done = statement->run(); !done) return done;
  }
  return {};
}

Status StoreTables::roll_back_to(std::uint32_t generation) {
  const std::string g = std::to_string(generation);
  return database_->exec(
      "DELETE FROM generations WHERE generation >= " + g + "; DELETE FROM species WHERE generation >= " + g +
      "; DELETE FROM bests WHERE generation >= " + g +
      "; DELETE FROM validations; DELETE FROM champion"
      "; DELETE FROM poisons WHERE generation >= " +
      g + "; DELETE FROM evaluations WHERE generation > " + g +
      "; DELETE FROM optional_evaluations WHERE generation > " + g +
      "; DELETE FROM elites WHERE updated >= " + g + "; DELETE FROM populations WHERE generation > " + g);
}

}  // namespace evograsp::server

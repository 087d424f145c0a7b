#include "server/store_reader.h"

#include <algorithm>

#include "common/message_check.h"
#include "server/store.h"
#include "server/store_schema.h"

namespace evograsp::server {
namespace {

// Runs `sql` with whatever `bind` binds and makes a value of every row. `read` reads the columns but the
// last, which is the seal.
template <class T, class Bind, class Read>
Result<std::vector<T>> select(Database& database, std::string_view table, std::string_view sql, Bind bind,
                              Read read) {
  auto statement = database.prepare(sql);
  if (!statement) return tl::unexpected<Error>(statement.error());
  bind(*statement);
  std::vector<T> rows;
  for (;;) {
    const auto more = statement->step();
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) return rows;
    T row = read(*statement);
    if (const Status sealed = statement->check_seal(table); !sealed)
      return tl::unexpected<Error>(sealed.error());
    rows.push_back(std::move(row));
  }
}

template <class T>
Result<std::optional<T>> first(Result<std::vector<T>> rows) {
  if (!rows) return tl::unexpected<Error>(rows.error());
  if (rows->empty()) return std::optional<T>();
  return std::optional<T>(std::move(rows->front()));
}

constexpr auto kNothing = [](Statement&) {};

GenerationRecord read_generation(Statement& s) {
  GenerationRecord r;
  r.generation = static_cast<std::uint32_t>(s.integer());
  r.best = s.real();
  r.mean = s.real();
  r.deviation = s.real();
  r.species = static_cast<std::uint32_t>(s.integer());
  r.threshold = s.real();
  r.best_genome = s.id();
  r.links = s.real();
  r.evaluations = s.id();
  r.trials = s.id();
  r.seconds = s.real();
  r.committed_at = s.real();
  return r;
}

BestRecord read_best(Statement& s) {
  BestRecord r;
  r.generation = static_cast<std::uint32_t>(s.integer());
  r.genome = s.id();
  r.fitness = s.real();
  r.genotype = s.blob();
  r.network = s.blob();
  return r;
}

struct RunRow {
  RunInfo info;
  bool parses = false;
};

RunRow read_run(Statement& s) {
  RunRow row;
  s.integer();
  row.info.run_id = s.id();
  row.info.name = s.text();
  s.integer();  // seed: in the config
  s.text();     // fingerprint: in the experiment
  row.info.build = s.text();
  row.info.created_at = s.real();
  s.text();  // config_text
  const std::string config = s.blob();
  const std::string experiment = s.blob();
  row.parses = row.info.config.ParseFromString(config) && row.info.experiment.ParseFromString(experiment);
  return row;
}

}  // namespace

Result<std::unique_ptr<StoreReader>> StoreReader::open(const std::filesystem::path& run_dir) {
  auto database = Database::open(run_dir / kStoreFile, Database::Mode::kReadOnly);
  if (!database) return tl::unexpected<Error>(database.error());
  if (const Status known = check_schema(**database); !known) return tl::unexpected<Error>(known.error());
  return std::unique_ptr<StoreReader>(new StoreReader(std::move(*database)));
}

Result<RunInfo> StoreReader::run() {
  const MutexLock lock(mutex_);
  auto row = first(select<RunRow>(*database_, "run", "SELECT * FROM run", kNothing, read_run));
  if (!row) return tl::unexpected<Error>(row.error());
  if (!*row || !(*row)->parses)
    return fail(ErrorCode::kInvalid,
                database_->file().string() + ": damaged: it does not say what run it is");
  const std::string name = database_->file().string();
  if (Status ok = check_message((*row)->info.config, name); !ok) return tl::unexpected<Error>(ok.error());
  if (Status ok = check_message((*row)->info.experiment, name); !ok) return tl::unexpected<Error>(ok.error());
  return std::move((*row)->info);
}

Result<RunProgress> StoreReader::progress() {
  const MutexLock lock(mutex_);
  auto row =
      first(select<RunProgress>(*database_, "progress", "SELECT * FROM progress", kNothing, [](Statement& s) {
        RunProgress p;
        s.integer();
        p.epoch = s.id();
        p.state = s.text();
        p.updated_at = s.real();
        return p;
      }));
  if (!row) return tl::unexpected<Error>(row.error());
  if (!*row)
    return fail(ErrorCode::kInvalid, database_->file().string() + ": damaged: table progress is empty");
  return **row;
}

Result<std::vector<StoredAsset>> StoreReader::assets() {
  const MutexLock lock(mutex_);
  return select<StoredAsset>(*database_, "assets", "SELECT * FROM assets ORDER BY id", kNothing,
                             [](Statement& s) {
                               StoredAsset a;
                               a.id = s.text();
                               a.kind = s.text();
                               a.name = s.text();
                               a.packed = s.blob();
                               return a;
                             });
}

Result<std::vector<GenerationRecord>> StoreReader::generations(std::uint32_t from, std::uint32_t limit) {
  const MutexLock lock(mutex_);
  return select<GenerationRecord>(
      *database_, "generations",
      "SELECT * FROM generations WHERE generation >= ? ORDER BY generation LIMIT ?",
      [&](Statement& s) { s.bind(std::int64_t{from}).bind(std::int64_t{limit}); }, read_generation);
}

Result<std::optional<GenerationRecord>> StoreReader::last_generation() {
  const MutexLock lock(mutex_);
  return first(select<GenerationRecord>(*database_, "generations",
                                        "SELECT * FROM generations ORDER BY generation DESC LIMIT 1",
                                        kNothing, read_generation));
}

Result<std::vector<neat::SpeciesSummary>> StoreReader::species(std::uint32_t generation) {
  const MutexLock lock(mutex_);
  return select<neat::SpeciesSummary>(
      *database_, "species", "SELECT * FROM species WHERE generation = ? ORDER BY species",
      [&](Statement& s) { s.bind(std::int64_t{generation}); },
      [](Statement& s) {
        neat::SpeciesSummary r;
        s.integer();
        r.id = static_cast<std::uint32_t>(s.integer());
        r.age = static_cast<std::uint32_t>(s.integer());
        r.last_improved = static_cast<std::uint32_t>(s.integer());
        r.size = static_cast<std::uint32_t>(s.integer());
        r.best = s.real();
        r.mean = s.real();
        return r;
      });
}

Result<std::vector<Event>> StoreReader::events(std::int64_t since, std::uint32_t limit) {
  const MutexLock lock(mutex_);
  const char* sql =
      since > 0 ? "SELECT * FROM events WHERE id > ? ORDER BY id LIMIT ?"
                : "SELECT * FROM (SELECT * FROM events WHERE id > ? ORDER BY id DESC LIMIT ?) ORDER BY id";
  return select<Event>(
      *database_, "events", sql, [&](Statement& s) { s.bind(since).bind(std::int64_t{limit}); },
      [](Statement& s) {
        Event e;
        e.id = s.integer();
        e.time = s.real();
        e.severity = static_cast<Severity>(std::clamp<std::int64_t>(s.integer(), 0, 2));
        e.kind = s.text();
        e.text = s.text();
        return e;
      });
}

Result<std::vector<WorkerRecord>> StoreReader::workers() {
  const MutexLock lock(mutex_);
  return select<WorkerRecord>(*database_, "workers", "SELECT * FROM workers ORDER BY identity", kNothing,
                              [](Statement& s) {
                                WorkerRecord w;
                                w.identity = s.text();
                                w.host = s.text();
                                w.build = s.text();
                                w.state = s.text();
                                w.slots = static_cast<std::uint32_t>(s.integer());
                                w.first_seen = s.real();
                                w.last_seen = s.real();
                                w.tasks = s.id();
                                w.trials = s.id();
                                return w;
                              });
}

Result<std::vector<BestRecord>> StoreReader::bests(std::uint32_t from, std::uint32_t limit) {
  const MutexLock lock(mutex_);
  return select<BestRecord>(
      *database_, "bests", "SELECT * FROM bests WHERE generation >= ? ORDER BY generation LIMIT ?",
      [&](Statement& s) { s.bind(std::int64_t{from}).bind(std::int64_t{limit}); }, read_best);
}

Result<std::optional<BestRecord>> StoreReader::best() {
  const MutexLock lock(mutex_);
  return first(select<BestRecord>(*database_, "bests",
                                  "SELECT * FROM bests ORDER BY fitness DESC, generation LIMIT 1", kNothing,
                                  read_best));
}

Result<std::vector<ValidationRecord>> StoreReader::validations() {
  const MutexLock lock(mutex_);
  return select<ValidationRecord>(*database_, "validations",
                                  "SELECT * FROM validations ORDER BY generation, genome", kNothing,
                                  [](Statement& s) {
                                    ValidationRecord v;
                                    v.generation = static_cast<std::uint32_t>(s.integer());
                                    v.genome = s.id();
                                    v.trials = static_cast<std::uint32_t>(s.integer());
                                    v.successes = static_cast<std::uint32_t>(s.integer());
                                    v.fitness = s.real();
                                    v.lift_trials = static_cast<std::uint32_t>(s.integer());
                                    v.lifts = static_cast<std::uint32_t>(s.integer());
                                    return v;
                                  });
}

Result<std::vector<PoisonRecord>> StoreReader::poisons() {
  const MutexLock lock(mutex_);
  return select<PoisonRecord>(*database_, "poisons", "SELECT * FROM poisons ORDER BY generation, genome",
                              kNothing, [](Statement& s) {
                                PoisonRecord p;
                                p.generation = static_cast<std::uint32_t>(s.integer());
                                p.genome = s.id();
                                p.reason = s.text();
                                p.network = s.blob();
                                p.trials = s.blob();
                                return p;
                              });
}

Result<std::vector<Evaluation>> StoreReader::evaluations(std::uint32_t generation) {
  const MutexLock lock(mutex_);
  return select<Evaluation>(
      *database_, "evaluations", "SELECT * FROM evaluations WHERE generation = ? ORDER BY genome",
      [&](Statement& s) { s.bind(std::int64_t{generation}); },
      [](Statement& s) {
        Evaluation e;
        e.generation = static_cast<std::uint32_t>(s.integer());
        e.genome = s.id();
        e.measurements = s.blob();
        return e;
      });
}

bool StoreReader::has_table(const char* name) {
  return database_->integer(std::string("SELECT count(*) FROM sqlite_schema WHERE name = '") + name + "'")
             .value_or(1) > 0;
}

Result<std::vector<Evaluation>> StoreReader::optional_evaluations(std::uint32_t generation) {
  const MutexLock lock(mutex_);
  if (!has_table("optional_evaluations")) return std::vector<Evaluation>();
  return select<Evaluation>(
      *database_, "optional_evaluations",
      "SELECT * FROM optional_evaluations WHERE generation = ? ORDER BY stage, genome",
      [&](Statement& s) { s.bind(std::int64_t{generation}); },
      [](Statement& s) {
        Evaluation e;
        e.generation = static_cast<std::uint32_t>(s.integer());
        e.stage = s.text();
        e.genome = s.id();
        e.measurements = s.blob();
        return e;
      });
}

Result<std::optional<std::uint32_t>> StoreReader::race_rounds(std::uint32_t generation) {
  const MutexLock lock(mutex_);
  if (!has_table("races")) return std::optional<std::uint32_t>();
  return first(select<std::uint32_t>(
      *database_, "races", "SELECT * FROM races WHERE generation = ?",
      [&](Statement& s) { s.bind(std::int64_t{generation}); },
      [](Statement& s) {
        s.integer();
        return static_cast<std::uint32_t>(s.integer());
      }));
}

Result<std::vector<EliteRecord>> StoreReader::elites() {
  const MutexLock lock(mutex_);
  if (!has_table("elites")) return std::vector<EliteRecord>();
  return select<EliteRecord>(*database_, "elites", "SELECT * FROM elites ORDER BY cell", kNothing,
                             [](Statement& s) {
                               const auto count = [&s] { return static_cast<std::uint32_t>(s.integer()); };
                               EliteRecord e;
                               e.cell = count();
                               e.x = count();
                               e.y = count();
                               e.x_value = s.real();
                               e.y_value = s.real();
                               e.fitness = s.real();
                               e.judged = count();
                               e.genome = s.id();
                               e.generation = count();
                               e.updated = count();
                               e.genotype = s.blob();
                               e.network = s.blob();
                               return e;
                             });
}

Result<std::string> StoreReader::champion() {
  const MutexLock lock(mutex_);
  auto row =
      first(select<std::string>(*database_, "champion", "SELECT * FROM champion", kNothing, [](Statement& s) {
        s.integer();
        return s.blob();
      }));
  if (!row) return tl::unexpected<Error>(row.error());
  return row->value_or("");
}

Result<std::vector<std::uint32_t>> StoreReader::populations() {
  const MutexLock lock(mutex_);
  auto statement = database_->prepare("SELECT generation FROM populations ORDER BY generation");
  if (!statement) return tl::unexpected<Error>(statement.error());
  std::vector<std::uint32_t> generations;
  for (;;) {
    const auto more = statement->step();
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) return generations;
    generations.push_back(static_cast<std::uint32_t>(statement->integer()));
  }
}

Result<StoreReader::PopulationState> StoreReader::population(std::uint32_t generation) {
  const MutexLock lock(mutex_);
  auto row = first(select<PopulationState>(
      *database_, "populations", "SELECT * FROM populations WHERE generation = ?",
      [&](Statement& s) { s.bind(std::int64_t{generation}); },
      [](Statement& s) {
        PopulationState p;
        p.generation = static_cast<std::uint32_t>(s.integer());
        p.state = s.blob();
        return p;
      }));
  if (!row) return tl::unexpected<Error>(row.error());
  if (!*row)
    return fail(ErrorCode::kNotFound, database_->file().string() + ": the population of generation " +
                                          std::to_string(generation) +
                                          " was not kept (store.keep_generations)");
  return std::move(**row);
}

}  // namespace evograsp::server

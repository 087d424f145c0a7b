#include "server/store_open.h"

#include <limits>
#include <system_error>

#include "server/store_reader.h"
#include "server/store_schema.h"
#include "server/store_tables.h"

namespace evograsp::server {
namespace {

constexpr std::uint32_t kAll = std::numeric_limits<std::uint32_t>::max();

// secure_delete would overwrite every pruned row with zeros; Debian builds SQLite with it on. Each generation
// writes the same pages again: a longer log (32 MB) folds more of them into one.
constexpr char kWriterSettings[] =
    "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA secure_delete = OFF; "
    "PRAGMA journal_size_limit = 67108864; PRAGMA cache_size = -4096; PRAGMA foreign_keys = OFF; "
    "PRAGMA wal_autocheckpoint = 4000";

template <class T>
tl::unexpected<Error> error_of(const T& result) {
  return tl::unexpected<Error>(result.error());
}

Status write_new(Database& database, const NewRun& run) {
  if (Status s = database.exec("PRAGMA page_size = 8192"); !s) return s;
  if (Status s = database.exec(kWriterSettings); !s) return s;
  if (Status s = database.exec("PRAGMA synchronous = FULL; BEGIN IMMEDIATE"); !s) return s;
  if (Status s = create_schema(database); !s) return s;
  auto tables = StoreTables::prepare(database);
  if (!tables) return error_of(tables);
  const double now = unix_time();
  if (Status s = tables->put_run(run.info, now); !s) return s;
  if (Status s = tables->put_progress({1, "running", now}); !s) return s;
  for (const StoredAsset& asset : run.assets)
    if (Status s = tables->put_asset(asset); !s) return s;
  if (Status s = tables->put_population(0, run.population); !s) return s;
  if (Status s = database.exec("COMMIT"); !s) return s;
  // What the run is moves into the file itself: a damaged log then costs generations, never the run.
  return database.exec("PRAGMA wal_checkpoint(TRUNCATE); PRAGMA synchronous = NORMAL");
}

Status quick_check(Database& database) {
  const auto verdict = database.text("PRAGMA quick_check(1)");
  if (!verdict) return error_of(verdict);
  if (*verdict == "ok") return {};
  return fail(ErrorCode::kInvalid,
              database.file().string() + ": damaged (" + *verdict +
                  "): restore a copy, or save what is left with: sqlite3 run.db .recover | sqlite3 new.db");
}

// What had to be left behind.
struct Damage {
  bool fell_back = false;    // to an older population
  bool evaluations = false;  // of the generation in progress
};

// The newest population whose seal holds.
Status find_state(StoreReader& reader, ResumePoint& point, Damage& damage) {
  const auto kept = reader.populations();
  if (!kept) return error_of(kept);
  std::string reason = "none is stored";
  for (auto generation = kept->rbegin(); generation != kept->rend(); ++generation) {
    auto state = reader.population(*generation);
    if (!state) {
      reason = state.error().message;
      point.warnings.push_back("population of generation " + std::to_string(*generation) +
                               " cannot be used, falling back to the one before: " + reason);
      damage.fell_back = true;
      continue;
    }
    point.generation = *generation;
    point.population = std::move(state->state);
    return {};
  }
  return fail(ErrorCode::kInvalid, "no population of this run can be read: " + reason);
}

// Journalled work is a convenience: a damaged row is evaluated again.
void find_evaluations(StoreReader& reader, ResumePoint& point, Damage& damage) {
  auto evaluations = reader.evaluations(point.generation);
  auto optional = reader.optional_evaluations(point.generation);
  if (evaluations && optional) {
    point.evaluations = std::move(*evaluations);
    point.optional = std::move(*optional);
  } else {
    damage.evaluations = true;
    point.warnings.push_back("journalled evaluations cannot be used and are done again: " +
                             (evaluations ? optional.error() : evaluations.error()).message);
  }
}

Status read_point(StoreReader& reader, ResumePoint& point, Damage& damage) {
  auto info = reader.run();
  if (!info) return error_of(info);
  point.info = std::move(*info);
  auto assets = reader.assets();
  if (!assets) return error_of(assets);
  point.assets = std::move(*assets);
  const auto progress = reader.progress();
  if (!progress) return error_of(progress);
  point.epoch = progress->epoch + 1;
  point.state = progress->state;
  if (Status s = find_state(reader, point, damage); !s) return s;
  find_evaluations(reader, point, damage);
  const auto rounds = reader.race_rounds(point.generation);
  if (!rounds) return error_of(rounds);
  point.rounds = *rounds;
  return {};
}

Status read_past(StoreReader& reader, ResumePoint& point) {
  auto history = reader.generations(0, kAll);
  if (!history) return error_of(history);
  point.history = std::move(*history);
  for (std::size_t i = 0; i < point.history.size(); ++i)
    if (point.history[i].generation != i)
      return fail(ErrorCode::kInvalid, "generation " + std::to_string(i) + " is missing from the history");
  if (point.history.size() != point.generation)
    return fail(ErrorCode::kInvalid, "the population is of generation " + std::to_string(point.generation) +
                                         " but " + std::to_string(point.history.size()) +
                                         " generations are in the history");
  const std::uint32_t candidates = point.info.config.champion().candidates();
  auto bests = reader.bests(point.generation > candidates ? point.generation - candidates : 0, kAll);
  if (!bests) return error_of(bests);
  point.bests = std::move(*bests);
  auto validations = reader.validations();
  if (!validations) return error_of(validations);
  point.validations = std::move(*validations);
  auto champion = reader.champion();
  if (!champion) return error_of(champion);
  point.champion = std::move(*champion);
  return {};
}

Status take_up(Database& database, ResumePoint& point) {
  StoreReader reader(&database);
  if (Status s = quick_check(database); !s) return s;
  if (Status s = upgrade_schema(database); !s) return s;
  Damage damage;
  if (Status s = read_point(reader, point, damage); !s) return s;
  auto tables = StoreTables::prepare(database);
  if (!tables) return error_of(tables);
  if (Status s = database.exec("PRAGMA synchronous = FULL; BEGIN IMMEDIATE"); !s) return s;
  if (damage.fell_back)
    if (Status s = tables->roll_back_to(point.generation); !s) return s;
  if (damage.evaluations)
    for (const char* table : {"evaluations", "optional_evaluations"})
      if (Status s = database.exec(std::string("DELETE FROM ") + table +
                                   " WHERE generation = " + std::to_string(point.generation));
          !s)
        return s;
  if (Status s = read_past(reader, point); !s) return s;
  if (Status s = tables->put_progress({point.epoch, "running", unix_time()}); !s) return s;
  return database.exec("COMMIT; PRAGMA synchronous = NORMAL");
}

}  // namespace

bool holds_run(const std::filesystem::path& run_dir) {
  const std::filesystem::path file = run_dir / kStoreFile;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return false;
  const auto found = Database::open(file, Database::Mode::kReadOnly);
  return !found || (*found)->integer("SELECT count(*) FROM sqlite_schema").value_or(1) != 0;
}

Result<OpenRun> open_new(const std::filesystem::path& run_dir, const NewRun& run) {
  std::error_code problem;
  std::filesystem::create_directories(run_dir, problem);
  if (problem) return fail(ErrorCode::kIo, run_dir.string() + ": cannot be made: " + problem.message());
  auto lock = RunLock::take(run_dir);
  if (!lock) return error_of(lock);
  const std::filesystem::path file = run_dir / kStoreFile;
  if (holds_run(run_dir))
    return fail(ErrorCode::kInvalid,
                file.string() + ": there is a run already; resume it (--resume), or choose another folder");
  auto database = Database::open(file, Database::Mode::kCreate);
  if (!database) return error_of(database);
  if (Status s = write_new(**database, run); !s) return error_of(s);
  return OpenRun{std::move(*lock), std::move(*database)};
}

Result<OpenRun> open_existing(const std::filesystem::path& run_dir, ResumePoint& point) {
  const std::filesystem::path file = run_dir / kStoreFile;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored))
    return fail(ErrorCode::kNotFound, file.string() + ": there is no run to resume here");
  auto lock = RunLock::take(run_dir);
  if (!lock) return error_of(lock);
  auto database = Database::open(file, Database::Mode::kReadWrite);
  if (!database) return error_of(database);
  if (Status s = check_schema(**database); !s) return error_of(s);
  if (Status s = (*database)->exec(kWriterSettings); !s) return error_of(s);
  if (Status s = take_up(**database, point); !s) {
    Error error = s.error();
    if (error.message.find(file.string()) == std::string::npos)
      error.message = file.string() + ": " + error.message;
    return tl::unexpected<Error>(std::move(error));
  }
  return OpenRun{std::move(*lock), std::move(*database)};
}

}  // namespace evograsp::server

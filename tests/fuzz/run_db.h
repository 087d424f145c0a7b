// Small run.db files for run_db_fuzz and its seeds.
#pragma once

#include "neat/population.h"
#include "server/store.h"
#include "tests/fuzz/fuzz.h"

namespace evograsp::fuzz {

inline proto::Config small_run_config() {
  proto::Config config;
  config.mutable_run()->set_name("small");
  config.mutable_neat()->set_population(3);
  return config;
}

inline std::string small_population() {
  return neat::Population::create(small_run_config().neat(), 2, 1, 1)->save();
}

inline server::NewRun small_run() {
  server::NewRun run;
  run.info.run_id = 1;
  run.info.name = "small";
  run.info.build = "test";
  run.info.config = small_run_config();
  run.info.experiment.add_object_id("aa");
  run.assets = {{"aa", "object", "cube", "packed"}};
  run.population = small_population();
  return run;
}

// Writes what is given to a new run: population, evaluation, best, network, champion.
inline bool fill(const std::filesystem::path& folder, server::NewRun run, Pieces& pieces) {
  std::string population(pieces.bytes());
  if (!population.empty()) run.population = population;
  auto store = server::Store::create(folder, std::move(run));
  if (!store) return false;
  server::GenerationCommit commit;
  commit.best.genotype = pieces.bytes();
  commit.best.network = pieces.bytes();
  commit.species = {{1, 1, 1, 3, 0.5, 0.25}};
  commit.population = pieces.bytes();
  if (commit.population.empty()) commit.population = small_population();
  (*store)->commit_generation(std::move(commit), [](const Status&) {});
  (*store)->journal({1, 0, std::string(pieces.bytes())});
  (*store)->note({0, 0, server::Severity::kInfo, "seed", std::string(pieces.bytes())});
  return (*store)->flush().has_value();
}

// A good file's bytes.
inline std::string small_run_db(const std::filesystem::path& folder) {
  Pieces nothing(nullptr, 0);
  fill(folder, small_run(), nothing);
  std::ifstream in(folder / server::kStoreFile, std::ios::binary);
  return std::string((std::istreambuf_iterator<char>(in)), {});
}

// A file whose every seal is right, about things that need not be: config and experiment first, then
// fill()'s.
inline bool write_sealed(const std::filesystem::path& folder, Pieces& pieces) {
  server::NewRun run = small_run();
  const std::string_view config = pieces.bytes(), experiment = pieces.bytes();
  if (!run.info.config.MergeFromString(std::string(config))) return false;
  if (!run.info.experiment.MergeFromString(std::string(experiment))) return false;
  return fill(folder, std::move(run), pieces);
}

}  // namespace evograsp::fuzz

// A run folder of its own for each test, and records to fill it with.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <future>
#include <string>

#include "common/digest.h"
#include "common/random.h"
#include "server/store.h"
#include "server/store_reader.h"

namespace evograsp::server {

class RunFolder {
 public:
  RunFolder() {
    // Memory when there is some: a sync then costs nothing, and what a sync promises is tested by real kills.
    std::error_code none;
    const std::filesystem::path memory = "/dev/shm";
    const bool usable = std::filesystem::is_directory(memory, none) && ::access(memory.c_str(), W_OK) == 0;
    std::string name =
        ((usable ? memory : std::filesystem::temp_directory_path()) / "evograsp_XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~RunFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path file() const { return path_ / kStoreFile; }

 private:
  std::filesystem::path path_;
};

inline std::string random_bytes(std::uint64_t key, std::size_t size) {
  Random random(key, Purpose::kTestHarness);
  std::string bytes(size, '\0');
  for (char& b : bytes) b = static_cast<char>(random.next());
  return bytes;
}

// What a population of generation g would be: any bytes that name the generation.
inline std::string population_of(std::uint32_t generation, std::size_t size = 20000) {
  return "population " + std::to_string(generation) + " " + random_bytes(generation, size);
}

inline NewRun new_run() {
  NewRun run;
  run.info.run_id = 0xfedcba9876543210;
  run.info.name = "cube";
  run.info.build = "test";
  run.info.config.mutable_run()->set_seed(18446744073709551615u);
  run.info.config.mutable_run()->set_name("cube");
  run.info.config.mutable_neat()->set_population(120);
  run.info.config.mutable_store()->set_journal_seconds(0.01);
  run.info.config.mutable_champion()->set_candidates(3);
  run.info.experiment.add_object_id("aa");
  run.info.experiment.set_fingerprint("f1");
  run.assets = {{"aa", "object", "cube_6cm", random_bytes(1, 5000)},
                {"bb", "hand", "meka_h2", random_bytes(2, 50)}};
  run.population = population_of(0);
  return run;
}

inline proto::Genome genome_of(std::uint64_t id) {
  proto::Genome genome;
  genome.set_id(id);
  genome.set_inputs(304);
  genome.set_outputs(7);
  return genome;
}

inline GenerationCommit commit_of(std::uint32_t generation) {
  GenerationCommit commit;
  commit.record.generation = generation;
  commit.record.best = 0.5 + 0.01 * generation;
  commit.record.mean = 0.1 * generation;
  commit.record.deviation = 0.25;
  commit.record.species = 2;
  commit.record.threshold = 3.0;
  commit.record.best_genome = 1000 + generation;
  commit.record.links = 311.5;
  commit.record.evaluations = 120 * (generation + 1);
  commit.record.trials = 600 * (generation + 1);
  commit.record.seconds = 0.25 * (generation + 1);
  commit.species = {{1, generation, generation, 70, 0.5, 0.25}, {2, 1, generation, 50, 0.75, 0.125}};
  commit.best.generation = generation;
  commit.best.genome = 1000 + generation;
  commit.best.fitness = commit.record.best;
  commit.best.genotype = genome_of(1000 + generation).SerializeAsString();
  proto::Network network;
  network.set_inputs(304);
  commit.best.network = network.SerializeAsString();
  commit.population = population_of(generation + 1);
  return commit;
}

inline Evaluation evaluation_of(std::uint32_t generation, std::uint64_t genome) {
  proto::Measurement m;
  m.set_quality(0.01 * static_cast<double>(genome));
  m.set_contacts(static_cast<std::uint32_t>(genome % 12));
  m.set_theta(90.5 + generation);
  return {generation, genome, pack_measurements({&m, 1})};
}

// Commits and waits for it.
inline Status commit(Store& store, GenerationCommit change) {
  std::promise<Status> promise;
  auto done = promise.get_future();
  store.commit_generation(std::move(change), [&](const Status& s) { promise.set_value(s); });
  store.hurry();
  return done.get();
}

// Whether everything that a resumed run leans on is exactly what was written.
inline ::testing::AssertionResult right(const ResumePoint& point) {
  const auto wrong = [](const std::string& what) {
    return ::testing::AssertionFailure() << what << " is not what was written";
  };
  if (point.population != population_of(point.generation))
    return wrong("population " + std::to_string(point.generation));
  if (deterministic_bytes(point.info.config) != deterministic_bytes(new_run().info.config))
    return wrong("config");
  if (point.info.run_id != new_run().info.run_id) return wrong("run id");
  if (point.assets.size() != 2 || point.assets[0].packed != new_run().assets[0].packed)
    return wrong("assets");
  for (const Evaluation& e : point.evaluations)
    if (e.generation != point.generation ||
        e.measurements != evaluation_of(e.generation, e.genome).measurements)
      return wrong("evaluation of genome " + std::to_string(e.genome));
  if (point.history.size() != point.generation) return wrong("length of the history");
  for (const GenerationRecord& g : point.history)
    if (g.best != commit_of(g.generation).record.best || g.seconds != commit_of(g.generation).record.seconds)
      return wrong("record of generation " + std::to_string(g.generation));
  for (const BestRecord& b : point.bests)
    if (b.genotype != commit_of(b.generation).best.genotype || b.genome != 1000 + b.generation)
      return wrong("best");
  return ::testing::AssertionSuccess();
}

inline std::string message(const Status& status) {
  return status ? "" : status.error().message;
}
template <class T>
std::string message(const Result<T>& result) {
  return result ? "" : result.error().message;
}

}  // namespace evograsp::server

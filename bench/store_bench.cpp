// run.db: what journalling an evaluation and committing a generation cost. Real disk, in the current folder.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>
#include <future>
#include <string>

#include "server/store.h"

namespace evograsp::server {
namespace {

std::filesystem::path fresh_folder() {
  std::string name = (std::filesystem::current_path() / "store_bench_XXXXXX").string();
  return ::mkdtemp(name.data());
}

proto::Measurement measurement() {
  proto::Measurement m;
  m.set_quality(0.123);
  m.set_contacts(7);
  for (proto::Vec3* v : {m.mutable_p(), m.mutable_s(), m.mutable_o()}) {
    v->set_x(0.1);
    v->set_y(0.2);
    v->set_z(0.3);
  }
  m.set_nearest_object(0.04);
  m.set_target_distance(0.04);
  m.set_theta(88);
  return m;
}

struct BenchRun {
  std::filesystem::path folder = fresh_folder();
  std::unique_ptr<Store> store;
  BenchRun() {
    NewRun run;
    run.info.config.mutable_store()->set_journal_seconds(0.2);
    run.population = "p";
    store = std::move(*Store::create(folder, run));
  }
  ~BenchRun() {
    store.reset();
    std::filesystem::remove_all(folder);
  }
};

void report(benchmark::State& state, double evaluations) {
  state.counters["evaluations/s"] = benchmark::Counter(evaluations, benchmark::Counter::kIsRate);
}

// One measurement an evaluation, packed by the caller as the dispatcher does, synced every 10,000
// evaluations. CPU time is the whole process's.
void journal(benchmark::State& state) {
  constexpr int kEvaluations = 10000;
  BenchRun run;
  const proto::Measurement m = measurement();
  std::uint32_t generation = 0;
  for (auto _ : state) {
    for (int i = 0; i < kEvaluations; ++i)
      run.store->journal({generation, static_cast<std::uint64_t>(i), pack_measurements({&m, 1})});
    if (!run.store->flush()) state.SkipWithError("the store failed");
    ++generation;
  }
  report(state, static_cast<double>(kEvaluations) * static_cast<double>(state.iterations()));
}
BENCHMARK(journal)
    ->Name("store/journal")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

// A generation of 120 genomes x 5 trials with 312 links each, and its evaluations.
void commit(benchmark::State& state) {
  BenchRun run;
  const std::vector<proto::Measurement> trials(5, measurement());
  std::uint32_t generation = 0;
  for (auto _ : state) {
    for (std::uint64_t genome = 0; genome < 120; ++genome)
      run.store->journal({generation, genome, pack_measurements(trials)});
    GenerationCommit change;
    change.record.generation = change.best.generation = generation++;
    change.species.resize(10);
    for (std::uint32_t s = 0; s < 10; ++s) change.species[s].id = s;
    change.best.genotype.resize(4000, 'g');
    change.best.network.resize(2500, 'n');
    change.population.resize(500000, 'p');
    std::promise<bool> done;
    run.store->commit_generation(std::move(change), [&](const Status& s) { done.set_value(s.has_value()); });
    if (!done.get_future().get()) state.SkipWithError("the commit failed");
  }
}
BENCHMARK(commit)
    ->Name("store/commit")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

}  // namespace
}  // namespace evograsp::server

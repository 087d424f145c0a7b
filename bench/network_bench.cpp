// Activation of a network of 2,500 links, as evolution leaves them: 304 inputs into 8 hidden nodes into 7
// outputs, two dozen later nodes on split links, and some direct links. activate_sparse: as many links
// between random nodes.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <set>
#include <vector>

#include "common/network.h"
#include "common/random.h"
#include "neat/population.h"

namespace {

using evograsp::Network;
using evograsp::Random;

constexpr std::uint32_t kInputs = 304, kOutputs = 7;
constexpr int kLinks = 2500;

Network evolved() {
  evograsp::proto::NeatConfig config;
  config.set_population(100);
  config.set_hidden(8);
  auto population = evograsp::neat::Population::create(config, kInputs, kOutputs, 1).value();
  Random random(1, evograsp::Purpose::kTestHarness);
  for (int g = 0; g < 30; ++g) {
    std::vector<double> fitness(population.ask().size());
    for (double& f : fitness) f = random.uniform();
    population.tell(fitness);
  }
  Network nearest = evograsp::neat::express(population.ask().front(), config);
  for (const auto& genome : population.ask()) {
    Network network = evograsp::neat::express(genome, config);
    if (std::abs(network.links() - kLinks) < std::abs(nearest.links() - kLinks)) nearest = std::move(network);
  }
  return nearest;
}

Network sparse() {
  constexpr std::uint32_t kHidden = 60, kNodes = kHidden + kOutputs;
  Random random(1, evograsp::Purpose::kTestHarness);
  std::vector<std::set<std::uint32_t>> sources(kNodes);
  for (int links = 0; links < kLinks;) {
    const std::uint32_t node = random.below(kNodes);
    links += sources[node].insert(random.below(kInputs + 1 + std::min(node, kHidden))).second;
  }
  evograsp::proto::Network proto;
  proto.set_inputs(kInputs);
  proto.set_outputs(kOutputs);
  proto.add_first_link(0);
  for (const auto& node : sources) {
    for (const std::uint32_t s : node) {
      proto.add_source(s);
      proto.add_weight(static_cast<float>(random.uniform(-1, 1)));
    }
    proto.add_first_link(static_cast<std::uint32_t>(proto.source_size()));
    proto.add_activation(evograsp::proto::TANH);
    proto.add_bias(0);
  }
  for (std::uint32_t o = 0; o < kOutputs; ++o) proto.add_output_node(kInputs + 1 + kHidden + o);
  return Network::from_proto(proto).value();
}

std::vector<float> inputs(std::size_t count) {
  Random random(2, evograsp::Purpose::kTestHarness);
  std::vector<float> in(count * kInputs);
  for (float& x : in) x = static_cast<float>(random.uniform());
  return in;
}

void one(benchmark::State& state, const Network& network) {
  const std::vector<float> in = inputs(1);
  std::vector<float> out(kOutputs);
  Network::Scratch scratch;
  for (auto _ : state) {
    network.activate(in, out, scratch);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  state.counters["links"] = network.links();
}

// Time is per sample.
void batch(benchmark::State& state, const Network& network) {
  constexpr int kBatch = 16;
  const std::vector<float> in = inputs(kBatch);
  std::vector<float> out(kBatch * kOutputs);
  Network::Scratch scratch;
  while (state.KeepRunningBatch(kBatch)) {
    network.activate_batch(in, out, kBatch, scratch);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  state.counters["links"] = network.links();
}

// Built when first asked for: listing benchmarks stays quick.
const Network& evolved_once() {
  static const Network network = evolved();
  return network;
}
const Network& sparse_once() {
  static const Network network = sparse();
  return network;
}

const bool registered = [] {
  benchmark::RegisterBenchmark("activate/2500", [](auto& state) { one(state, evolved_once()); });
  benchmark::RegisterBenchmark("activate_batch/2500", [](auto& state) { batch(state, evolved_once()); });
  benchmark::RegisterBenchmark("activate_sparse/2500", [](auto& state) { one(state, sparse_once()); });
  benchmark::RegisterBenchmark("activate_sparse_batch/2500",
                               [](auto& state) { batch(state, sparse_once()); });
  return true;
}();

}  // namespace

// Evaluates a population on this machine's threads: for tests, benchmarks and small experiments. The engine
// itself has no threads and does not use this.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "neat/express.h"
#include "neat/population.h"

namespace evograsp::neat {

// fitness[i] = judge(network of genomes[i]); judge is called from `threads` threads at once. What comes back
// does not depend on their number.
template <class Judge>
std::vector<double> evaluate(std::span<const Genome> genomes, const proto::NeatConfig& config, Judge judge,
                             unsigned threads = 1) {
  std::vector<double> fitness(genomes.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    Expressor expressor(config);
    for (std::size_t i = next++; i < genomes.size(); i = next++)
      fitness[i] = judge(expressor.express(genomes[i]));
  };
  std::vector<std::jthread> helpers;
  for (unsigned t = 1; t < threads; ++t) helpers.emplace_back(work);
  work();
  helpers.clear();  // joins
  return fitness;
}

}  // namespace evograsp::neat

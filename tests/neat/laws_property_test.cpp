// What must hold whatever the config, the seed and the history.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "common/isa.h"
#include "neat/crossover.h"
#include "neat/distance.h"
#include "neat/express.h"
#include "neat/local_evaluator.h"
#include "neat/mutation.h"
#include "neat/reproduction.h"
#include "neat/topology.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

using testing::evolve;
using testing::lively;
using testing::weigh;

// Every operator at random rates, every topology, recurrent or not.
proto::NeatConfig random_config(Random& random) {
  proto::NeatConfig config = lively(10 + random.below(60));
  config.set_topology(static_cast<proto::Topology>(random.below(4)));
  config.set_hidden(random.below(4));
  config.set_recurrent(random.chance(0.3));
  config.set_connect_bias_to_outputs(random.chance(0.5));
  config.set_normalise_by_genes(random.chance(0.5));
  config.set_target_species(random.chance(0.3) ? 0 : 1 + random.below(10));
  config.set_add_node(random.uniform());
  config.set_add_connection(random.uniform());
  config.set_crossover(random.uniform());
  config.set_drop_off_age(random.below(6));
  config.set_refocus_age(random.below(4));
  config.set_elite_min_size(random.below(8));
  config.set_survival(random.uniform(0.01, 1));
  config.set_depth_weight_scale(random.chance(0.5) ? 1 : 0.1);
  return config;
}

Population make(const proto::NeatConfig& config, int inputs, int outputs, std::uint64_t seed) {
  auto population = Population::create(config, inputs, outputs, seed);
  EXPECT_TRUE(population) << population.error().message;
  return std::move(*population);
}

TEST(Laws, GenomesStaySoundUnderEveryOperator) {
  Random random(1, Purpose::kTestHarness);
  for (int trial = 0; trial < 60; ++trial) {
    const proto::NeatConfig config = random_config(random);
    const int inputs = 1 + static_cast<int>(random.below(12)),
              outputs = 1 + static_cast<int>(random.below(5));
    Population population = make(config, inputs, outputs, random.next());
    for (int g = 0; g < 25; ++g) {
      std::vector<double> fitness;
      for (const Genome& genome : population.ask()) fitness.push_back(weigh(genome) * random.uniform(-1, 1));
      population.tell(fitness);
      ASSERT_EQ(population.ask().size(), config.population());
      std::size_t members = 0;
      for (const auto& m : population.members()) members += m.size();
      ASSERT_EQ(members, config.population());
      for (const Genome& genome : population.ask()) {
        const Status status = check(genome, config.recurrent());
        ASSERT_TRUE(status) << status.error().message << " in generation " << g << " of\n"
                            << config.DebugString();
      }
    }
  }
}

TEST(Laws, OneInnovationMeansOneLinkWithinARun) {
  Random random(2, Purpose::kTestHarness);
  for (int trial = 0; trial < 10; ++trial) {
    const auto config = random_config(random);
    Population population = make(config, 4, 3, random.next());
    std::map<std::uint32_t, std::pair<std::uint32_t, std::uint32_t>> meaning;
    for (int g = 0; g < 25; ++g) {
      for (const Genome& genome : population.ask())
        for (std::uint32_t i = 0; i < genome.links(); ++i) {
          const std::pair ends(genome.source(i), genome.target(i));
          EXPECT_EQ(meaning.try_emplace(genome.innovation(i), ends).first->second, ends);
        }
      evolve(population, 1);
    }
  }
}

std::vector<Genome> some_genomes(std::uint64_t seed, bool recurrent = false) {
  proto::NeatConfig config = lively(80);
  config.set_recurrent(recurrent);
  config.set_add_node(0.5);
  config.set_add_connection(0.6);
  Population population = make(config, 30, 3, seed);
  evolve(population, 25);
  return {population.ask().begin(), population.ask().end()};
}

TEST(Laws, DistanceIsSymmetricToTheBitAndZeroOnItself) {
  const std::vector<Genome> genomes = some_genomes(3);
  const DistanceWeights weights{proto::NeatConfig()};
  for (const Genome& a : genomes) {
    EXPECT_EQ(distance(a, a, weights), 0);
    for (const Genome& b : genomes) {
      EXPECT_EQ(distance(a, b, weights), distance(b, a, weights));
      EXPECT_GE(distance(a, b, weights), 0);
    }
  }
}

TEST(Laws, CrossoverOfEqualsIsIdentity) {
  proto::NeatConfig config = lively();
  config.set_disabled_in_either(1);  // else a link disabled in both may come back, as the paper has it
  Random random(4, Purpose::kTestHarness);
  for (const Genome& genome : some_genomes(4)) {
    Genome child;
    crossover(genome, genome, config, random, child);
    EXPECT_TRUE(child == genome);
  }
}

TEST(Laws, AChildHasItsFitterParentsStructure) {
  const std::vector<Genome> genomes = some_genomes(5);
  Random random(5, Purpose::kTestHarness);
  for (int t = 0; t < 500; ++t) {
    const Genome& a = genomes[random.below(80)];
    const Genome& b = genomes[random.below(80)];
    Genome child = genomes[random.below(80)];  // storage used again
    crossover(a, b, lively(), random, child);
    ASSERT_EQ(child.links(), a.links());
    for (std::uint32_t i = 0; i < a.links(); ++i) ASSERT_EQ(child.innovation(i), a.innovation(i));
    ASSERT_TRUE(check(child, false));
  }
}

TEST(Laws, AllotmentAlwaysSums) {
  Random random(6, Purpose::kTestHarness);
  for (int t = 0; t < 5000; ++t) {
    std::vector<double> shares(1 + random.below(40));
    for (double& s : shares) {
      const double mantissa = random.uniform();
      const int exponent = static_cast<int>(random.below(200)) - 100;
      s = random.chance(0.3) ? 0 : std::ldexp(mantissa, exponent);
    }
    const std::uint32_t total = random.below(2000);
    const auto parts = allot(shares, total);
    EXPECT_EQ(std::accumulate(parts.begin(), parts.end(), 0u), total);
    const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
    for (std::size_t s = 0; s < shares.size() && sum > 0; ++s)
      EXPECT_NEAR(parts[s], shares[s] / sum * total, 1.0 + 1e-9 * total) << "no species drifts by rounding";
  }
}

TEST(Laws, CycleCheckAgreesWithTheTransitiveClosure) {
  for (const Genome& genome : some_genomes(7)) {
    const std::uint32_t first = genome.start().first_output();
    std::map<std::uint32_t, std::set<std::uint32_t>> reach;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::uint32_t i = 0; i < genome.links(); ++i) {
        std::set<std::uint32_t> add = reach[genome.target(i)];
        add.insert(genome.target(i));
        auto& have = reach[genome.source(i)];
        const std::size_t before = have.size();
        have.insert(add.begin(), add.end());
        changed |= have.size() != before;
      }
    }
    for (std::uint32_t s = 0; s < genome.computed_nodes(); ++s)
      for (std::uint32_t t = 0; t < genome.computed_nodes(); ++t) {
        const std::uint32_t source = genome.node_id(s), target = genome.node_id(t);
        ASSERT_GE(source, first);
        EXPECT_EQ(closes_cycle(genome, source, target), source == target || reach[target].contains(source));
      }
  }
}

// The phenotype by definition: repeated relaxation of the enabled links, in double precision.
std::vector<double> by_definition(const Genome& genome, std::span<const float> in) {
  std::map<std::uint32_t, double> value;
  for (std::uint32_t i = 0; i < genome.inputs(); ++i) value[i] = static_cast<double>(in[i]);
  value[genome.bias_node()] = 1;
  for (std::uint32_t round = 0; round <= genome.computed_nodes(); ++round) {
    std::map<std::uint32_t, double> sum;
    for (std::uint32_t k = 0; k < genome.computed_nodes(); ++k)
      sum[genome.node_id(k)] = static_cast<double>(genome.bias(k));
    for (std::uint32_t i = 0; i < genome.links(); ++i)
      if (genome.enabled(i))
        sum[genome.target(i)] += static_cast<double>(genome.weight(i)) * value[genome.source(i)];
    for (std::uint32_t k = 0; k < genome.computed_nodes(); ++k) {
      const float x = static_cast<float>(sum[genome.node_id(k)]);
      value[genome.node_id(k)] = static_cast<double>(activation::apply<float>(genome.activation(k), x));
    }
  }
  std::vector<double> out;
  for (std::uint32_t k = 0; k < genome.outputs(); ++k) out.push_back(value[genome.node_id(k)]);
  return out;
}

TEST(Laws, TheNetworkComputesWhatTheGenomeSays) {
  Random random(8, Purpose::kTestHarness);
  Network::Scratch scratch;
  for (const Genome& genome : some_genomes(8)) {
    std::vector<float> in(30), out(3);
    for (float& x : in) x = static_cast<float>(random.uniform(-1, 1));
    express(genome, lively()).activate(in, out, scratch);
    const std::vector<double> expected = by_definition(genome, in);
    for (std::size_t o = 0; o < 3; ++o) EXPECT_NEAR(out[o], expected[o], 2e-3);
  }
}

TEST(Laws, ARecurrentNetworkStepsLikeItsDefinition) {
  proto::NeatConfig config = lively();
  config.set_recurrent(true);
  Random random(9, Purpose::kTestHarness);
  int with_cycle = 0;
  for (const Genome& genome : some_genomes(9, true)) {
    with_cycle += !is_acyclic(genome);
    const Network network = express(genome, config);
    std::vector<float> in(30), out(3), stepped(3);
    for (float& x : in) x = static_cast<float>(random.uniform(-1, 1));
    Network::Scratch scratch;
    Network::State state;
    for (int steps = 1; steps <= 5; ++steps) {
      network.activate(in, out, scratch, steps);
      network.step(in, stepped, state);
      EXPECT_EQ(out, stepped) << "five steps one by one are five steps at once";
    }
  }
  EXPECT_GT(with_cycle, 20);
}

TEST(Laws, SteeringHoldsTheNumberOfSpeciesWhereDistancesConcentrate) {
  for (const std::uint32_t hidden : {1u, 4u}) {
    proto::NeatConfig config;
    config.set_population(150);
    config.set_hidden(hidden);
    Population population = make(config, 304, 7, hidden);
    Random random(10, Purpose::kTestHarness);
    for (int g = 0; g < 60; ++g) {
      const std::size_t species = population.members().size();
      EXPECT_GE(species, 4u) << "generation " << g;
      EXPECT_LE(species, 20u) << "generation " << g;
      std::vector<double> fitness(150);
      for (double& f : fitness) f = random.uniform();
      population.tell(fitness);
    }
  }
}

TEST(Laws, EveryInstructionSetBreedsTheSameBytes) {
  const Isa usual = active_isa();
  for (const double scale : {0.3, 1.0}) {
    std::string first;
    for (const Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}) {
      if (!runs_here(isa)) continue;
      force_isa(isa);
      proto::NeatConfig config = lively(40);
      config.set_depth_weight_scale(scale);
      Population population = make(config, 60, 3, 11);
      evolve(population, 15);
      if (first.empty()) first = population.save();
      EXPECT_EQ(population.save(), first) << name(isa);
    }
  }
  force_isa(usual);
}

TEST(Laws, WhoEvaluatesAndOnHowManyThreadsChangesNothing) {
  const auto run = [](unsigned threads) {
    Population population = make(lively(), 6, 2, 12);
    for (int g = 0; g < 10; ++g)
      population.tell(evaluate(
          population.ask(), lively(),
          [](const Network& network) {
            Network::Scratch scratch;
            const std::vector<float> in(6, 0.5f);
            std::vector<float> out(2);
            network.activate(in, out, scratch);
            return static_cast<double>(out[0] - out[1]);
          },
          threads));
    return population.save();
  };
  EXPECT_EQ(run(1), run(4));
}

TEST(Laws, DamagedStatesAreRefusedOrSound) {
  const proto::NeatConfig config = lively(20);
  Population population = make(config, 4, 2, 13);
  evolve(population, 6);
  const std::string good = population.save();
  Random random(13, Purpose::kTestHarness);
  for (int t = 0; t < 3000; ++t) {
    std::string bad = good;
    for (std::uint32_t k = 0; k <= random.below(3); ++k)
      bad[random.below(static_cast<std::uint32_t>(bad.size()))] = static_cast<char>(random.below(256));
    if (random.chance(0.2)) bad.resize(random.below(static_cast<std::uint32_t>(bad.size())));
    auto loaded = Population::load(config, bad);
    if (!loaded) continue;
    for (const Genome& genome : loaded->ask()) ASSERT_TRUE(check(genome, false));
    evolve(*loaded, 1);
    ASSERT_EQ(loaded->ask().size(), 20u);
  }
  proto::NeatConfig other = config;
  other.set_hidden(3);
  EXPECT_FALSE(Population::load(other, good)) << "made with another topology";
}

}  // namespace
}  // namespace evograsp::neat

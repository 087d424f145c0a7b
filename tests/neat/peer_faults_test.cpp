// Faults that other implementations of NEAT are known for, each with a test that would find it here. (The
// others are tested where they belong: OneInnovationMeansOneLinkWithinARun, AllotmentAlwaysSums,
// SteeringHoldsTheNumberOfSpeciesWhereDistancesConcentrate and CycleCheckAgreesWithTheTransitiveClosure in
// laws_property_test.cpp.)
#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <set>
#include <thread>

#include "neat/crossover.h"
#include "neat/distance.h"
#include "neat/express.h"
#include "neat/local_evaluator.h"
#include "neat/mutation.h"
#include "neat/reproduction.h"
#include "neat/start.h"
#include "neat/topology.h"
#include "proto/population.pb.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

// 1000 inputs, 300 outputs, and `links` links that came after the start, the n-th with innovation n * step.
Genome late(std::uint32_t links, std::uint32_t step) {
  proto::NeatConfig config;
  config.set_topology(proto::UNCONNECTED);
  Random random(1);
  Genome genome = make_first(config, make_start(config, 1000, 300), random);
  for (std::uint32_t n = 0; n < links; ++n)
    genome.insert({(n + 1) * step, n % 1000, 1001 + n / 1000, 1.0f, true});
  return genome;
}

TEST(PeerFaults, CrossoverAndDistanceWalkThroughLargeGenomesOnce) {
  // A search among the other's genes for each of these would be 10^13 comparisons: this test would not end.
  const Genome a = late(300'000, 2), b = late(300'000, 3);
  const proto::NeatConfig config;
  Random random(2);
  for (int t = 0; t < 50; ++t) {
    Genome child;
    crossover(a, b, config, random, child);
    ASSERT_EQ(child.links(), 300'000u);
    // Innovations 6, 12, ... 600,000 match; the rest of both up to the end of a's is disjoint, b's last
    // excess.
    DistanceWeights c(config);
    c.by_genes = false;
    EXPECT_EQ(distance(a, b, c), 1.0 * 100'000 + 2.0 * (200'000 + 100'000));
  }
}

TEST(PeerFaults, CycleChecksSeeEachLinkOnce) {
  // A ladder of 20,000 steps: as many as 2^20000 ways from its foot to its head.
  proto::NeatConfig config;
  config.set_topology(proto::UNCONNECTED);
  Random random(1);
  Genome genome = make_first(config, make_start(config, 2, 1), random);
  constexpr std::uint32_t kSteps = 20'000;
  std::uint32_t innovation = 0, node = 4;
  std::uint32_t last[2] = {0, 1};
  for (std::uint32_t step = 0; step < kSteps; ++step, node += 2) {
    for (const std::uint32_t n : {node, node + 1}) {
      genome.insert_hidden(n, Activation::kTanh, 0);
      for (const std::uint32_t l : last) genome.insert({++innovation, l, n, 0.7f, true});
    }
    last[0] = node, last[1] = node + 1;
  }
  genome.insert({++innovation, last[0], 3, 1, true});
  EXPECT_TRUE(is_acyclic(genome));
  EXPECT_TRUE(closes_cycle(genome, last[0], 4)) << "head to foot";
  EXPECT_FALSE(closes_cycle(genome, 4, last[0])) << "foot to head";
  const Network network = Expressor(config).express(genome);  // its order is no exponential depth() either
  EXPECT_EQ(network.computed_nodes(), static_cast<int>(2 * kSteps));
}

TEST(PeerFaults, APopulationKeepsItsSizeWhateverTheSharesAre) {
  for (const std::uint32_t size : {2u, 7u, 53u, 101u}) {
    proto::NeatConfig config = testing::lively(size);
    config.set_target_species(size / 2);
    auto population = Population::create(config, 4, 2, size).value();
    Random random(size, Purpose::kTestHarness);
    for (int g = 0; g < 60; ++g) {
      std::vector<double> fitness(size);
      for (double& f : fitness) f = random.chance(0.3) ? -1 / (random.uniform() + 1e-12) : random.uniform();
      population.tell(fitness);
      ASSERT_EQ(population.ask().size(), size) << "generation " << g;
    }
  }
}

TEST(PeerFaults, DisabledFlagsNeitherLeakNorRevert) {
  // With disabled_in_either 1 nothing comes back by crossover, in copies, when links are added, or over a
  // file.
  proto::NeatConfig config = testing::lively(40);
  config.set_toggle_enabled(0);
  config.set_reenable(0);
  config.set_disabled_in_either(1);
  Random random(5, Purpose::kTestHarness);
  const auto start = make_start(config, 70, 3);
  Innovations innovations(start->links() + 1, start->first_hidden() + start->hidden);
  Genome genome = make_first(config, start, random);
  std::set<std::uint32_t> disabled;  // by innovation
  for (int t = 0; t < 300; ++t) {
    innovations.next_generation();
    const Genome parent = genome;
    if (t % 3 == 0) add_node(genome, config, innovations, random);
    if (t % 3 == 1) add_connection(genome, config, innovations, random);
    if (t % 3 == 2) crossover(parent, parent, config, random, genome);
    for (std::uint32_t i = 0; i < genome.links(); ++i)
      if (!genome.enabled(i)) disabled.insert(genome.innovation(i));
    for (std::uint32_t i = 0; i < genome.links(); ++i)
      ASSERT_EQ(genome.enabled(i), !disabled.contains(genome.innovation(i)))
          << "link " << i << ", step " << t;
    const std::size_t splits = static_cast<std::size_t>(t / 3 + 1);
    ASSERT_EQ(disabled.size(), splits) << "one link a split";
  }
}

TEST(PeerFaults, NumbersFollowTheChildrenInTheirOrderAndNothingElse) {
  // Innovations, nodes and ids are given as the children stand in ask(): ascending, without gaps, and the
  // same mutation has the same number in all of them.
  proto::NeatConfig config = testing::lively(50);
  config.set_add_node(0.8);
  config.set_add_connection(0.8);
  auto population = Population::create(config, 5, 2, 9).value();
  int shared = 0;
  for (int g = 0; g < 12; ++g) {
    proto::PopulationState before, after;
    ASSERT_TRUE(before.ParseFromString(population.save()));
    testing::evolve(population, 1);
    ASSERT_TRUE(after.ParseFromString(population.save()));
    std::uint32_t innovation = before.next_innovation(), node = before.next_node();
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> number;  // of this generation's links
    for (std::uint32_t c = 0; c < population.ask().size(); ++c) {
      const Genome& child = population.ask()[c];
      if (child.id() >= before.next_genome()) {
        EXPECT_EQ(child.id(), before.next_genome() + c);
      }
      for (std::uint32_t i = child.start_links(); i < child.links(); ++i) {
        if (child.innovation(i) < before.next_innovation()) continue;
        if (child.innovation(i) >= innovation) {
          ASSERT_EQ(child.innovation(i), innovation) << "child " << c << " of generation " << g;
          ++innovation;
        } else {
          ++shared;
        }
        const std::pair ends(child.source(i), child.target(i));
        EXPECT_EQ(number.try_emplace(ends, child.innovation(i)).first->second, child.innovation(i));
      }
      for (std::uint32_t j = 0; j < child.hidden_nodes(); ++j)
        if (child.hidden_id(j) >= node) {
          ASSERT_EQ(child.hidden_id(j), node) << "child " << c << " of generation " << g;
          ++node;
        }
    }
    EXPECT_EQ(innovation, after.next_innovation());
    EXPECT_EQ(node, after.next_node());
  }
  EXPECT_GT(shared, 20) << "the same mutation twice in a generation";
}

TEST(PeerFaults, WhoIsJudgedFirstDecidesNothing) {
  // Of each four genomes the first is judged last, which would show were fitness taken as it comes.
  const auto breed = [](unsigned threads) {
    const proto::NeatConfig config = testing::lively(48);
    auto population = Population::create(config, 5, 2, 9).value();
    for (int g = 0; g < 8; ++g) {
      std::atomic<std::uint32_t> begun = 0, ended = 0;
      const std::vector<float> in(5, 0.5f);
      population.tell(evaluate(
          population.ask(), config,
          [&](const Network& network) {
            const std::uint32_t turn = begun++;
            while (threads == 4 && turn % 4 == 0 && ended < turn + 3) std::this_thread::yield();
            Network::Scratch scratch;
            std::vector<float> out(2);
            network.activate(in, out, scratch);
            ++ended;
            return 2.0 + static_cast<double>(out[0] - out[1]);
          },
          threads));
    }
    return population.save();
  };
  EXPECT_EQ(breed(1), breed(4));
}

TEST(PeerFaults, FitnessBelowZeroCanBeTheBest) {
  // std::numeric_limits<double>::min() is no minus infinity: a best of -3 must beat it.
  auto population = Population::create(testing::lively(30), 4, 2, 3).value();
  for (int g = 0; g < 10; ++g) {
    std::vector<double> fitness(30, -7.0);
    fitness[11] = -3.0;
    population.tell(fitness);
    double best = -1e9;
    for (const SpeciesSummary& s : population.species()) best = std::max(best, s.best);
    EXPECT_EQ(best, -3.0);
    const Ranking ranking(fitness);
    EXPECT_EQ(ranking.best(), 11u);
  }
}

TEST(PeerFaults, FeedForwardMeansNoCycleWhateverIsSwitchedOn) {
  // Disabled links count: a cycle that rests today is a cycle when its link is enabled again.
  proto::NeatConfig config = testing::lively(40);
  config.set_add_node(0.6);
  config.set_add_connection(0.9);
  config.set_toggle_enabled(0.5);
  config.set_reenable(0.5);
  auto population = Population::create(config, 3, 3, 4).value();
  for (int g = 0; g < 40; ++g) {
    testing::evolve(population, 1);
    for (Genome genome : population.ask()) {
      for (std::uint32_t i = 0; i < genome.links(); ++i) genome.set_enabled(i, true);
      ASSERT_TRUE(is_acyclic(genome)) << "generation " << g;
      ASSERT_FALSE(Expressor(config).express(genome).recurrent());
    }
  }
}

TEST(PeerFaults, ASplitTwiceInOneGenomeGivesTwoNodes) {
  proto::NeatConfig config;
  config.set_topology(proto::DIRECT);
  Random random(6);
  const auto start = make_start(config, 1, 1);
  Genome genome = make_first(config, start, random);
  Innovations innovations(start->links() + 1, start->first_hidden());
  std::set<std::uint32_t> nodes;
  for (int t = 0; t < 5; ++t) {
    innovations.next_generation();
    for (std::uint32_t i = 0; i < genome.links(); ++i) genome.set_enabled(i, i == 0);  // the same link again
    ASSERT_TRUE(add_node(genome, config, innovations, random));
    EXPECT_TRUE(nodes.insert(genome.hidden_id(genome.hidden_nodes() - 1)).second);
    ASSERT_TRUE(check(genome, false)) << check(genome, false).error().message;
  }
  EXPECT_EQ(genome.hidden_nodes(), 5u);
}

}  // namespace
}  // namespace evograsp::neat

// Single operators on genomes small enough to work out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "neat/crossover.h"
#include "neat/distance.h"
#include "neat/genome_compiler.h"
#include "neat/mutation.h"
#include "neat/reproduction.h"
#include "neat/start.h"
#include "neat/topology.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

proto::NeatConfig unconnected() {
  proto::NeatConfig config;
  config.set_topology(proto::UNCONNECTED);
  return config;
}

// inputs 0, 1, 2; bias 3; outputs 4, 5; hidden from 6.
Genome empty_genome(const proto::NeatConfig& config = unconnected()) {
  Random random(1);
  return make_first(config, make_start(config, 3, 2), random);
}

Genome with(std::vector<Link> links, std::vector<std::uint32_t> hidden = {}) {
  Genome genome = empty_genome();
  for (const std::uint32_t node : hidden) genome.insert_hidden(node, Activation::kTanh, 0);
  for (const Link& link : links) genome.insert(link);
  return genome;
}

TEST(Genome, KeepsLinksSortedWhateverOrderTheyComeIn) {
  const Genome genome = with({{9, 0, 4, 0.9f, false}, {2, 1, 4, 0.2f, true}, {5, 2, 5, 0.5f, true}});
  EXPECT_EQ(genome.link(0), (Link{2, 1, 4, 0.2f, true}));
  EXPECT_EQ(genome.link(1), (Link{5, 2, 5, 0.5f, true}));
  EXPECT_EQ(genome.link(2), (Link{9, 0, 4, 0.9f, false}));
  EXPECT_TRUE(genome.has_link(0, 4));
  EXPECT_FALSE(genome.has_link(0, 5));
}

TEST(Genome, FlagsMoveWithTheirLinksAcrossWords) {
  Genome genome = with({}, {6});
  for (std::uint32_t i = 200; i > 0; --i) genome.insert({i, i % 3, 4 + i % 3, 0, i % 7 != 0});
  for (std::uint32_t i = 0; i < 200; ++i) EXPECT_EQ(genome.enabled(i), (i + 1) % 7 != 0) << i;
}

TEST(Genome, CheckNamesWhatIsWrong) {
  EXPECT_TRUE(check(with({{1, 0, 6, 1, true}, {2, 6, 4, 1, true}}, {6}), false));
  EXPECT_FALSE(check(with({{1, 0, 7, 1, true}}, {6}), false)) << "no such target";
  EXPECT_FALSE(check(with({{1, 7, 4, 1, true}}, {6}), false)) << "no such source";
  EXPECT_FALSE(check(with({{1, 0, 2, 1, true}}), false)) << "computes into an input";
  EXPECT_FALSE(check(with({{1, 0, 4, 1, true}, {2, 0, 4, 1, true}}), false)) << "double";
  EXPECT_FALSE(check(with({{1, 0, 4, std::nanf(""), true}}), false)) << "weight";
  const Genome loop = with({{1, 6, 7, 1, true}, {2, 7, 6, 1, false}}, {6, 7});
  EXPECT_FALSE(check(loop, false)) << "a cycle, even through a disabled link";
  EXPECT_TRUE(check(loop, true));
}

TEST(Distance, FollowsTheFormula) {
  // a: 1 2 3 5; b: 1 2 4 6 7. Matching 1, 2; disjoint 3, 4, 5; excess 6, 7.
  const Genome a =
      with({{1, 0, 4, 1.0f, true}, {2, 1, 4, 2.0f, true}, {3, 2, 4, 0, true}, {5, 0, 5, 0, true}});
  const Genome b = with({{1, 0, 4, 1.5f, true},
                         {2, 1, 4, 1.0f, true},
                         {4, 1, 5, 0, true},
                         {6, 2, 5, 0, true},
                         {7, 3, 5, 0, true}});
  proto::NeatConfig config;
  config.set_c1_excess(1);
  config.set_c2_disjoint(10);
  config.set_c3_weight(100);
  EXPECT_DOUBLE_EQ(distance(a, b, DistanceWeights(config)), 1 * 2 + 10 * 3 + 100 * 0.75)
      << "below 20 genes N is 1";
  EXPECT_DOUBLE_EQ(distance(b, a, DistanceWeights(config)), 107);
  EXPECT_EQ(distance(a, a, DistanceWeights(config)), 0);
  EXPECT_EQ(distance(empty_genome(), empty_genome(), DistanceWeights(config)), 0);
}

TEST(Distance, DividesByTheGenesOfTheLargerUnlessTold) {
  std::vector<Link> many;
  for (std::uint32_t i = 0; i < 25; ++i) many.push_back({i + 1, i % 3, 4 + i / 3, 0, true});
  std::vector<std::uint32_t> hidden;
  for (std::uint32_t n = 6; n < 13; ++n) hidden.push_back(n);
  proto::NeatConfig config;
  EXPECT_DOUBLE_EQ(distance(with(many, hidden), empty_genome(), DistanceWeights(config)), 1.0);
  config.set_normalise_by_genes(false);
  EXPECT_DOUBLE_EQ(distance(with(many, hidden), empty_genome(), DistanceWeights(config)), 25.0);
}

TEST(Crossover, TakesMatchingGenesFromEitherAndTheRestFromTheFitter) {
  const Genome fitter = with({{1, 0, 4, 1, true}, {3, 1, 4, 1, true}, {8, 2, 4, 1, false}});
  const Genome other = with({{1, 0, 4, 2, true}, {2, 0, 5, 2, true}, {3, 1, 4, 2, true}, {9, 1, 5, 2, true}});
  Random random(3);
  int theirs = 0;
  for (int t = 0; t < 1000; ++t) {
    Genome child;
    crossover(fitter, other, unconnected(), random, child);
    ASSERT_EQ(child.links(), 3u);
    EXPECT_EQ(child.link(2), fitter.link(2)) << "excess, with its flag";
    for (std::uint32_t i = 0; i < 2; ++i) {
      EXPECT_TRUE(child.enabled(i)) << "enabled in both";
      EXPECT_TRUE(child.weight(i) == 1 || child.weight(i) == 2);
      theirs += child.weight(i) == 2;
    }
  }
  EXPECT_NEAR(theirs, 1000, 100);
}

TEST(Crossover, DisabledInEitherParentStaysSoAtItsRateInStartAndLateLinks) {
  proto::NeatConfig config;
  config.set_topology(proto::DIRECT);
  Random random(4);
  const auto start = make_start(config, 3, 2);
  Genome a = make_first(config, start, random), b = make_first(config, start, random);
  for (Genome* g : {&a, &b}) {
    g->insert_hidden(6, Activation::kTanh, 0);
    g->insert({10, 0, 6, 1, true});
    g->insert({11, 6, 4, 1, true});
  }
  a.set_enabled(1, false);                           // in one
  b.set_enabled(2, false);                           // in the other
  a.set_enabled(3, false), b.set_enabled(3, false);  // in both
  b.set_enabled(7, false);                           // a late one
  int disabled[8] = {};
  for (int t = 0; t < 4000; ++t) {
    Genome child;
    crossover(a, b, config, random, child);
    for (std::uint32_t i = 0; i < 8; ++i) disabled[i] += !child.enabled(i);
  }
  for (const int i : {1, 2, 3, 7}) EXPECT_NEAR(disabled[i], 3000, 150) << i;
  for (const int i : {0, 4, 5, 6}) EXPECT_EQ(disabled[i], 0) << i;
}

TEST(Crossover, AveragesAllMatchingWeightsOrNone) {
  proto::NeatConfig config;
  config.set_topology(proto::DIRECT);
  Random random(12);
  const auto start = make_start(config, 3, 2);
  Genome a = make_first(config, start, random), b = make_first(config, start, random);
  for (Genome* g : {&a, &b}) g->insert_hidden(6, Activation::kTanh, 0);
  a.insert({10, 0, 6, 1.0f, true}), b.insert({10, 0, 6, -4.0f, true});
  a.insert({11, 6, 4, 5.0f, true});  // excess
  const auto averaged = [&](const Genome& child) {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < b.links(); ++i)
      count += child.weight(i) == 0.5f * (a.weight(i) + b.weight(i));
    return count;
  };
  for (const double rate : {0.0, 0.3, 1.0}) {
    config.set_mate_average(rate);
    int times = 0;
    for (int t = 0; t < 2000; ++t) {
      Genome child;
      crossover(a, b, config, random, child);
      EXPECT_EQ(child.weight(b.links()), 5.0f) << "the fitter's alone";
      const std::uint32_t count = averaged(child);
      ASSERT_TRUE(count == 0 || count == b.links()) << count << " of " << b.links();
      times += count > 0;
    }
    EXPECT_NEAR(times, rate * 2000, rate == 0.3 ? 80 : 0);
  }
}

TEST(AddNode, KeepsTheOldWeightBehindTheNewNode) {
  Genome genome = with({{1, 2, 5, -0.75f, true}});
  Innovations innovations(10, 6);
  Random random(5);
  ASSERT_TRUE(add_node(genome, unconnected(), innovations, random));
  EXPECT_EQ(genome.link(0), (Link{1, 2, 5, -0.75f, false}));
  EXPECT_EQ(genome.link(1), (Link{10, 2, 6, 1.0f, true}));
  EXPECT_EQ(genome.link(2), (Link{11, 6, 5, -0.75f, true}));
  EXPECT_TRUE(check(genome, false));
}

TEST(AddNode, TheSameSplitHasTheSameNumbersInAGenerationAndOthersInTheNext) {
  Innovations innovations(10, 6);
  Random random(6);
  Genome a = with({{1, 0, 4, 1, true}}), b = a;
  add_node(a, unconnected(), innovations, random);
  add_node(b, unconnected(), innovations, random);
  EXPECT_EQ(a.hidden_id(0), b.hidden_id(0));
  EXPECT_EQ(a.innovation(1), b.innovation(1));
  // The split link comes back to life and is split again: a second node beside the first.
  innovations.next_generation();
  a.set_enabled(0, true), a.set_enabled(1, false), a.set_enabled(2, false);
  add_node(a, unconnected(), innovations, random);
  EXPECT_EQ(a.hidden_nodes(), 2u);
  EXPECT_EQ(a.links(), 5u);
  EXPECT_TRUE(check(a, false)) << check(a, false).error().message;
}

TEST(AddNode, SplitsNothingWhenNothingIsEnabled) {
  Genome genome = with({{1, 0, 4, 1, false}});
  Innovations innovations(10, 6);
  Random random(7);
  EXPECT_FALSE(add_node(genome, unconnected(), innovations, random));
  Genome bias_only = with({{1, 3, 4, 1, true}});
  EXPECT_FALSE(add_node(bias_only, unconnected(), innovations, random));
}

TEST(AddConnection, FillsTheGraphThenGivesUpAndNeverClosesACycle) {
  Genome genome = with({{1, 0, 6, 1, true}, {2, 6, 7, 1, true}, {3, 7, 4, 1, true}}, {6, 7});
  Innovations innovations(10, 8);
  Random random(8);
  int added = 0;
  for (int t = 0; t < 2000; ++t) added += add_connection(genome, unconnected(), innovations, random);
  EXPECT_TRUE(check(genome, false)) << check(genome, false).error().message;
  // 4 sources x 4 targets, 2 hidden x 2 outputs, one link between the hidden nodes; three were there.
  EXPECT_EQ(genome.links(), 4u * 4 + 2 * 2 + 1);
  EXPECT_EQ(added, 4 * 4 + 2 * 2 + 1 - 3);
}

TEST(AddConnection, TheSameLinkHasTheSameNumberInAGenerationAndAnotherInTheNext) {
  // Of all links 2 -> 5 alone is missing, but for c, which lacks 0 -> 4.
  const auto all_but = [](std::uint32_t source, std::uint32_t target) {
    std::vector<Link> links;
    for (std::uint32_t s = 0; s < 4; ++s)
      for (std::uint32_t t = 4; t < 6; ++t)
        if (s != source || t != target) links.push_back({1 + 2 * s + t - 4, s, t, 1, true});
    return with(links);
  };
  Genome a = all_but(2, 5), b = a, c = all_but(0, 4), later = a;
  Innovations innovations(100, 6);
  Random random(13);
  for (Genome* g : {&a, &c, &b})  // another mutation between the two
    for (int t = 0; t < 50; ++t) add_connection(*g, unconnected(), innovations, random);
  ASSERT_EQ(a.links(), 8u);
  ASSERT_EQ(b.links(), 8u);
  EXPECT_EQ(a.link(7).innovation, 100u);
  EXPECT_EQ(std::pair(a.source(7), a.target(7)), (std::pair(2u, 5u)));
  EXPECT_EQ(b.link(7).innovation, 100u);
  EXPECT_EQ(c.link(7).innovation, 101u);
  innovations.next_generation();
  for (int t = 0; t < 50; ++t) add_connection(later, unconnected(), innovations, random);
  EXPECT_EQ(later.link(7).innovation, 102u);
}

TEST(MutateWeights, PerturbsOrReplacesAtTheConfiguredRatesWithinTheLimit) {
  proto::NeatConfig config;
  config.set_hidden(4);
  config.set_max_weight(3);
  Random random(9);
  const Genome before = make_first(config, make_start(config, 304, 7), random);
  int replaced = 0, total = 0;
  double sum = 0, largest = 0;
  for (int t = 0; t < 50; ++t) {
    Genome genome = before;
    mutate_weights(genome, config, random);
    for (std::uint32_t i = 0; i < genome.links(); ++i) {
      const double moved = static_cast<double>(genome.weight(i) - before.weight(i));
      ++total;
      replaced += std::fabs(moved) > 0.5;  // only replacement moves farther than the power
      if (std::fabs(moved) <= 0.5) sum += moved, largest = std::max(largest, std::fabs(moved));
    }
  }
  // Replacement draws from +-1 about weights in +-1: farther than 0.5 with chance (1.5 / 2)^2.
  EXPECT_NEAR(static_cast<double>(replaced) / total, 0.1 * 0.5625, 0.004);
  EXPECT_NEAR(sum / total, 0, 0.005);
  EXPECT_GT(largest, 0.499);
}

TEST(MutateWeights, DepthScaleShrinksOnlyLinksFromDepth) {
  proto::NeatConfig config;
  config.set_depth_weight_scale(0.01);
  Random random(10);
  Genome genome = make_first(config, make_start(config, 304, 7), random);
  for (int t = 0; t < 5; ++t) mutate_weights(genome, config, random);
  for (std::uint32_t i = 0; i < 300; ++i) EXPECT_LE(std::fabs(genome.weight(i)), 0.036f);
  double rest = 0;
  for (std::uint32_t i = 300; i < genome.links(); ++i)
    rest += std::fabs(static_cast<double>(genome.weight(i)));
  EXPECT_GT(rest / 11, 0.2);
}

TEST(Start, FeaturesReadThroughHiddenNodesAndDirectly) {
  proto::NeatConfig config;
  config.set_topology(proto::FEATURES);
  config.set_hidden(3);
  config.set_other_inputs(7);  // click, box and a centroid
  const auto start = make_start(config, 307, 7);
  EXPECT_EQ(start->hidden, 3U);
  EXPECT_EQ(start->links(), (7U + 3) * (7 + 1) + 7 * 3);
  for (std::uint32_t h = 0; h < 3; ++h) {
    EXPECT_TRUE(start->contains(307, start->first_hidden() + h)) << "the bias of a hidden node";
    EXPECT_TRUE(start->contains(start->first_hidden() + h, start->first_output() + 6));
    EXPECT_FALSE(start->contains(299, start->first_hidden() + h)) << "a depth sample";
  }
  EXPECT_TRUE(start->contains(300, start->first_output() + 6));
}

TEST(Start, FeaturesLinksEverythingButDepthToEveryOutput) {
  proto::NeatConfig config;
  config.set_topology(proto::FEATURES);
  config.set_hidden(0);
  config.set_other_inputs(7);  // click, box and a centroid
  const auto start = make_start(config, 307, 7);
  EXPECT_EQ(start->links(), 7U * (7 + 1));
  EXPECT_EQ(start->hidden, 0U);
  for (std::uint32_t i = 0; i < start->links(); ++i) {
    EXPECT_GE(start->source[i], 300U);
    EXPECT_LE(start->source[i], 307U);  // the bias
  }
  EXPECT_TRUE(start->contains(300, start->first_output()));
  EXPECT_FALSE(start->contains(299, start->first_output()));
}

TEST(Allot, IsProportionalByLargestRemainder) {
  using Parts = std::vector<std::uint32_t>;
  EXPECT_EQ(allot(std::vector{1.0, 1.0, 1.0}, 10), (Parts{4, 3, 3}));
  EXPECT_EQ(allot(std::vector{5.0, 3.0, 2.0}, 10), (Parts{5, 3, 2}));
  EXPECT_EQ(allot(std::vector{0.0, 0.0}, 3), (Parts{2, 1}));
  EXPECT_EQ(allot(std::vector{1e-300, 0.0}, 3), (Parts{3, 0}));
  EXPECT_EQ(allot(std::vector{41.0, 35.0, 24.0}, 10), (Parts{4, 4, 2}));
}

TEST(Ranking, NegativeFitnessStillRanks) {
  const std::vector<double> fitness = {-5, -2, -9, std::nan("")};
  const Ranking ranking(fitness);
  EXPECT_EQ(ranking.best(), 1u);
  EXPECT_EQ(ranking.shared(2), 0);
  EXPECT_EQ(ranking.shared(1), 7);
  EXPECT_TRUE(ranking.better(2, 3)) << "the worst number is better than none";
}

TEST(Compiler, ALadderThatDoublesItsPathsEachStepTakesNoTime) {
  // 200 steps of two nodes, each reading both of the step before: 2^200 paths.
  Genome genome = empty_genome();
  std::uint32_t innovation = 0, node = 6;
  std::uint32_t last[2] = {0, 1};
  for (int step = 0; step < 200; ++step) {
    const std::uint32_t now[2] = {node, node + 1};
    node += 2;
    for (const std::uint32_t n : now) {
      genome.insert_hidden(n, Activation::kTanh, 0);
      for (const std::uint32_t l : last) genome.insert({++innovation, l, n, 0.7f, true});
    }
    last[0] = now[0], last[1] = now[1];
  }
  genome.insert({++innovation, last[0], 4, 1, true});
  ASSERT_TRUE(check(genome, false));
  EXPECT_TRUE(closes_cycle(genome, last[1], 6));
  GenomeCompiler compiler(false);
  const NetworkColumns columns = compiler.columns(genome);
  EXPECT_EQ(columns.activation.size(), 399u + 2) << "the last step's second node reaches no output";
  EXPECT_TRUE(Network::from_columns(columns));
}

TEST(Compiler, LeavesOutWhatIsDisabledAndWhatReachesNoOutput) {
  const Genome genome =
      with({{1, 0, 6, 1, true}, {2, 6, 7, 1, true}, {3, 6, 4, 0.5f, true}, {4, 1, 4, 1, false}}, {6, 7});
  GenomeCompiler compiler(false);
  const NetworkColumns columns = compiler.columns(genome);
  EXPECT_EQ(columns.activation.size(), 3u);
  EXPECT_EQ(std::vector<std::uint32_t>(columns.source.begin(), columns.source.end()),
            (std::vector<std::uint32_t>{0, 4}));
}

}  // namespace
}  // namespace evograsp::neat

// The operators that the defaults leave off, each for itself, and how often mutate() calls which.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "neat/mutation.h"
#include "neat/start.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

// Inputs 0, 1, 2, bias 3, outputs 4, 5, hidden 6, 7, 8; ten links, of which the third, the sixth and the last
// rest.
Genome sample() {
  proto::NeatConfig config;
  config.set_topology(proto::UNCONNECTED);
  Random random(1);
  Genome genome = make_first(config, make_start(config, 3, 2), random);
  for (const std::uint32_t node : {6u, 7u, 8u}) genome.insert_hidden(node, Activation::kTanh, 0.5f);
  std::uint32_t innovation = 0;
  for (const auto& [source, target] : {std::pair(0u, 4u),
                                       {1u, 5u},
                                       {0u, 6u},
                                       {6u, 4u},
                                       {1u, 7u},
                                       {7u, 5u},
                                       {2u, 8u},
                                       {8u, 4u},
                                       {2u, 4u},
                                       {3u, 5u}}) {
    ++innovation;
    genome.insert(
        {innovation, source, target, 0.25f, innovation != 3 && innovation != 6 && innovation != 10});
  }
  return genome;
}

struct Difference {
  int flags = 0, weights = 0, biases = 0, activations = 0;
  std::uint32_t flag = 0, node = 0;  // the last of them
};

Difference compare(const Genome& a, const Genome& b) {
  Difference d;
  EXPECT_EQ(a.links(), b.links());
  EXPECT_EQ(a.hidden_nodes(), b.hidden_nodes());
  for (std::uint32_t i = 0; i < a.links(); ++i) {
    if (a.enabled(i) != b.enabled(i)) ++d.flags, d.flag = i;
    d.weights += a.weight(i) != b.weight(i);
  }
  for (std::uint32_t k = 0; k < a.computed_nodes(); ++k) {
    d.biases += a.bias(k) != b.bias(k);
    if (a.activation(k) != b.activation(k)) ++d.activations, d.node = k;
  }
  return d;
}

TEST(Toggle, TurnsOneLinkOverEachAsOften) {
  Random random(2);
  std::array<int, 10> turned{};
  for (int t = 0; t < 5000; ++t) {
    Genome genome = sample();
    toggle_enabled(genome, random);
    const Difference d = compare(sample(), genome);
    ASSERT_EQ(d.flags, 1);
    ASSERT_EQ(d.weights + d.biases + d.activations, 0);
    ++turned[d.flag];
  }
  for (const int times : turned) EXPECT_NEAR(times, 500, 100);
}

TEST(Reenable, WakesTheOldestRestingLinkAndThenTheNext) {
  Genome genome = sample();
  for (const std::uint32_t expected : {2u, 5u, 9u}) {
    const Genome before = genome;
    reenable(genome);
    const Difference d = compare(before, genome);
    EXPECT_EQ(d.flags, 1);
    EXPECT_EQ(d.flag, expected);
    EXPECT_TRUE(genome.enabled(expected));
  }
  const Genome before = genome;
  reenable(genome);
  EXPECT_TRUE(genome == before) << "nothing rests";
}

TEST(MutateBiases, MovesOrReplacesEachLikeAWeight) {
  proto::NeatConfig config;
  config.set_perturb_power(0.1);
  config.set_initial_weight(2);
  config.set_max_weight(1.5);
  Random random(3);
  int far = 0, total = 0;
  for (int t = 0; t < 4000; ++t) {
    Genome genome = sample();
    mutate_biases(genome, config, random);
    const Difference d = compare(sample(), genome);
    ASSERT_EQ(d.flags + d.weights + d.activations, 0);
    for (std::uint32_t k = 0; k < genome.computed_nodes(); ++k, ++total) {
      ASSERT_LE(std::fabs(genome.bias(k)), 1.5f);
      far += std::fabs(static_cast<double>(genome.bias(k) - sample().bias(k))) > 0.1;
    }
  }
  // One in ten is drawn anew from +-2, of these 5 in 100 within 0.1 of where it was (0 or 0.5).
  EXPECT_NEAR(static_cast<double>(far) / total, 0.1 * 0.95, 0.01);
}

TEST(MutateActivation, GivesOneHiddenNodeAFunctionOfTheChoice) {
  proto::NeatConfig config;
  for (const auto f : {proto::SINE, proto::RELU}) config.add_hidden_choice(f);
  Random random(4);
  std::array<int, 5> changed{};
  int sines = 0;
  for (int t = 0; t < 3000; ++t) {
    Genome genome = sample();
    mutate_activation(genome, config, random);
    const Difference d = compare(sample(), genome);
    ASSERT_EQ(d.activations, 1);
    ASSERT_EQ(d.flags + d.weights + d.biases, 0);
    ++changed[d.node];
    const Activation f = genome.activation(d.node);
    ASSERT_TRUE(f == static_cast<Activation>(proto::SINE) || f == static_cast<Activation>(proto::RELU));
    sines += f == static_cast<Activation>(proto::SINE);
  }
  EXPECT_EQ(changed[0] + changed[1], 0) << "outputs keep theirs";
  for (const int k : {2, 3, 4}) EXPECT_NEAR(changed[static_cast<std::size_t>(k)], 1000, 130);
  EXPECT_NEAR(sines, 1500, 150);
}

TEST(Mutate, CallsEachOperatorAtItsOwnRateAndNoOther) {
  using Set = void (proto::NeatConfig::*)(double);
  using Changed = std::function<bool(const Genome&)>;
  const auto differs = [](auto member) {
    return [member](const Genome& g) { return compare(sample(), g).*member > 0; };
  };
  struct Operator {
    std::string name;
    Set set;
    Changed changed;
  };
  const Operator operators[] = {
      {"add_node", &proto::NeatConfig::set_add_node, [](auto& g) { return g.hidden_nodes() == 4; }},
      {"add_connection", &proto::NeatConfig::set_add_connection, [](auto& g) { return g.links() == 11; }},
      {"mutate_weights", &proto::NeatConfig::set_mutate_weights, differs(&Difference::weights)},
      {"mutate_bias", &proto::NeatConfig::set_mutate_bias, differs(&Difference::biases)},
      {"mutate_activation", &proto::NeatConfig::set_mutate_activation, differs(&Difference::activations)},
      {"toggle_enabled", &proto::NeatConfig::set_toggle_enabled, differs(&Difference::flags)},
      {"reenable", &proto::NeatConfig::set_reenable, differs(&Difference::flags)},
  };
  for (const Operator& chosen : operators)
    for (const double rate : {0.0, 0.2, 0.7, 1.0}) {
      proto::NeatConfig config;
      for (const Operator& each : operators) (config.*each.set)(0);
      (config.*chosen.set)(rate);
      config.add_hidden_choice(proto::SINE);
      Innovations innovations(100, 9);
      Random random(5, Purpose::kTestHarness);
      int changed = 0, same = 0;
      for (int t = 0; t < 2000; ++t) {
        Genome genome = sample();
        mutate(genome, config, innovations, random);
        if (genome == sample())
          ++same;
        else
          changed += chosen.changed(genome);
      }
      EXPECT_EQ(changed + same, 2000) << chosen.name << " changed something else";
      EXPECT_NEAR(changed, rate * 2000, rate > 0 && rate < 1 ? 90 : 0) << chosen.name << " at " << rate;
    }
}

TEST(Mutation, StepsHalveEverySoManyGenerations) {
  proto::NeatConfig config;
  config.set_perturb_power(0.2);
  EXPECT_EQ(perturb_power(config, 1000), 0.2) << "they stay, unless asked";
  config.set_perturb_halving(50);
  EXPECT_EQ(perturb_power(config, 0), 0.2);
  EXPECT_NEAR(perturb_power(config, 25), 0.2 / std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(perturb_power(config, 150), 0.025, 1e-15);
  EXPECT_EQ(perturb_power(config, 4000000000U), 0);
}

// A population whose weights are moved and nothing else: what a child's weight is away from any parent's.
TEST(Mutation, APopulationTakesSmallerStepsLater) {
  proto::NeatConfig config;
  config.set_population(30);
  config.set_hidden(1);
  config.set_mutate_weights(1);
  config.set_perturb_weight(1);
  config.set_perturb_power(0.5);
  config.set_perturb_halving(4);
  config.set_add_node(0);
  config.set_add_connection(0);
  config.set_crossover(0);
  auto population = Population::create(config, 5, 2, 3);
  ASSERT_TRUE(population);
  for (std::uint32_t generation = 0; generation < 12; ++generation) {
    const std::vector<Genome> parents(population->ask().begin(), population->ask().end());
    population->tell(std::vector<double>(30, 1.0));
    float largest = 0;
    for (const Genome& child : population->ask()) {
      float nearest = 10;
      for (const Genome& parent : parents) {
        float moved = 0;
        for (std::uint32_t i = 0; i < child.links(); ++i)
          moved = std::max(moved, std::fabs(child.weight(i) - parent.weight(i)));
        nearest = std::min(nearest, moved);
      }
      largest = std::max(largest, nearest);
    }
    const double step = perturb_power(config, generation);
    EXPECT_LE(largest, 1.0001 * step) << "generation " << generation;
    EXPECT_GT(largest, 0.7 * step) << "generation " << generation;
  }
}

}  // namespace
}  // namespace evograsp::neat

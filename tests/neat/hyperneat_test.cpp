#include "neat/hyperneat.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "neat/express.h"
#include "neat/start.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

constexpr std::uint32_t kBias = 5, kOut = 6;  // CPPN nodes: x1 y1 x2 y2 d, bias, outputs
enum { kX1, kY1, kX2, kY2, kDistance };
enum { kDepthGroup, kExtraGroup, kExtraOut, kHiddenOut, kHiddenBias, kOutBias, kCppnOutputs };

proto::NeatConfig config(double threshold = 0) {
  proto::NeatConfig c;
  c.set_topology(proto::UNCONNECTED);
  c.set_output_activation(proto::LINEAR);
  proto::HyperNeatConfig& h = *c.mutable_hyperneat();
  h.set_input_columns(6);
  h.set_input_rows(4);
  h.set_link_threshold(threshold);
  h.set_max_weight(2);
  proto::SubstrateSheet& sheet = *h.add_hidden_sheet();
  sheet.set_columns(3);
  sheet.set_rows(2);
  return c;
}

Genome cppn(std::vector<Link> links, Activation hidden = Activation::kAbs, std::uint32_t hidden_nodes = 0) {
  const proto::NeatConfig c = config();
  Random random(1);
  Genome genome = make_first(c, make_start(c, kCppnInputs, kCppnOutputs), random);
  for (std::uint32_t n = 0; n < hidden_nodes; ++n) genome.insert_hidden(kOut + kCppnOutputs + n, hidden, 0);
  for (const Link& link : links) genome.insert(link);
  return genome;
}

// Weight by (source, target): targets are 0.. of the hidden sheet, then of the outputs.
std::map<std::pair<std::uint32_t, std::uint32_t>, float> weights(const Network& network) {
  const proto::Network p = network.to_proto();
  std::map<std::pair<std::uint32_t, std::uint32_t>, float> result;
  for (int n = 0; n < p.activation_size(); ++n)
    for (auto k = static_cast<int>(p.first_link(n)); k < static_cast<int>(p.first_link(n + 1)); ++k)
      result[{p.source(k), static_cast<std::uint32_t>(n)}] = p.weight(k);
  return result;
}

TEST(HyperNeat, WeightsAreWhatTheCppnSaysOfTheirPlaces) {
  // depth -> hidden: x1; extras -> hidden: nothing.
  const Network network = Expressor(config()).express(cppn({{1, kX1, kOut + kDepthGroup, 0.5f, true}}));
  EXPECT_EQ(network.inputs(), 6 * 4 + 4);
  EXPECT_EQ(network.outputs(), 7);
  const auto w = weights(network);
  EXPECT_EQ(w.size(), 24u * 6);
  for (const auto& [ends, weight] : w) {
    const int column = static_cast<int>(ends.first % 6);
    EXPECT_FLOAT_EQ(weight, 0.5f * 2 * static_cast<float>(2 * column - 5) / 5);
  }
}

TEST(HyperNeat, LinksAtOrBelowTheThresholdAreLeftOutAndTheRestStartFromZero) {
  const auto w = weights(Expressor(config(0.5)).express(cppn({{1, kX1, kOut + kDepthGroup, 1.0f, true}})));
  for (const auto& [ends, weight] : w) {
    const float x = static_cast<float>(2 * static_cast<int>(ends.first % 6) - 5) / 5;
    EXPECT_GT(std::fabs(x), 0.5f);
    EXPECT_FLOAT_EQ(weight, std::copysign((std::fabs(x) - 0.5f) * 2 * 2, x));
  }
  EXPECT_EQ(w.size(), 4u * 4 * 6) << "four of six columns";
}

TEST(HyperNeat, SymmetryOfTheCppnIsSymmetryOfTheNetwork) {
  // |x1| and |y2 - y1| through hidden nodes: mirrored left to right the weights are the same to the bit.
  const std::uint32_t n = kOut + kCppnOutputs;
  const Network network = Expressor(config()).express(cppn({{1, kX1, n, 0.7f, true},
                                                            {2, n, kOut + kDepthGroup, 0.6f, true},
                                                            {3, kY1, n + 1, 0.4f, true},
                                                            {4, kY2, n + 1, -0.4f, true},
                                                            {5, n + 1, kOut + kDepthGroup, 0.5f, true}},
                                                           Activation::kGaussian, 2));
  const auto w = weights(network);
  ASSERT_EQ(w.size(), 24u * 6);
  for (const auto& [ends, weight] : w) {
    const std::uint32_t row = ends.first / 6, column = ends.first % 6;
    EXPECT_EQ(weight, w.at({row * 6 + (5 - column), ends.second})) << "left to right";
    const std::uint32_t hidden_row = ends.second / 3, hidden_column = ends.second % 3;
    EXPECT_EQ(weight, w.at({(3 - row) * 6 + column, (1 - hidden_row) * 3 + hidden_column}))
        << "both sheets upside down";
  }
}

TEST(HyperNeat, DistanceAloneGivesFieldsThatTurnWithTheSheet) {
  const auto w = weights(Expressor(config()).express(
      cppn({{1, kDistance, kOut + kDepthGroup, -0.3f, true}, {2, kBias, kOut + kDepthGroup, 0.9f, true}})));
  for (const auto& [ends, weight] : w)  // turned by half a circle
    EXPECT_EQ(weight, w.at({23 - ends.first, 5 - ends.second}));
}

TEST(HyperNeat, BiasesComeFromTheirOwnOutputs) {
  const proto::Network p =
      Expressor(config())
          .express(cppn({{1, kX2, kOut + kHiddenBias, 0.5f, true}, {2, kBias, kOut + kOutBias, 0.25f, true}}))
          .to_proto();
  ASSERT_EQ(p.bias_size(), 6 + 7);
  for (int n = 0; n < 6; ++n) EXPECT_FLOAT_EQ(p.bias(n), static_cast<float>(n % 3 - 1));
  for (int n = 6; n < 13; ++n) EXPECT_FLOAT_EQ(p.bias(n), 0.5f);
}

TEST(HyperNeat, ClickAndBoxHaveLinksOfTheirOwn) {
  const auto w = weights(Expressor(config()).express(cppn({{1, kBias, kOut + kExtraOut, 0.5f, true}})));
  EXPECT_EQ(w.size(), 4u * 7);
  for (const auto& [ends, weight] : w) {
    EXPECT_TRUE(ends.first >= 24 && ends.first < 28);
    EXPECT_FLOAT_EQ(weight, 1.0f);
  }
}

TEST(HyperNeat, EvolvesLargerSheetsThroughTheSameEngine) {
  proto::NeatConfig c = testing::lively(10);
  c.mutable_hyperneat()->set_input_columns(40);
  c.mutable_hyperneat()->set_input_rows(30);
  auto population = Population::create(c, 1204, 7, 1);
  ASSERT_TRUE(population) << population.error().message;
  testing::evolve(*population, 5);
  for (const Genome& genome : population->ask()) {
    EXPECT_TRUE(check(genome, false));
    const Network network = express(genome, c);
    EXPECT_EQ(network.inputs(), 1204);
    EXPECT_EQ(network.computed_nodes(), 80 + 7);
  }
}

TEST(HyperNeat, RefusesASubstrateThatDoesNotFit) {
  proto::NeatConfig c = config();
  EXPECT_TRUE(Population::create(c, 28, 7, 1));
  EXPECT_FALSE(Population::create(c, 304, 7, 1)) << "another camera";
  EXPECT_FALSE(Population::create(c, 28, 6, 1));
  c.set_recurrent(true);
  EXPECT_FALSE(Population::create(c, 28, 7, 1));
  c = config();
  for (int k = 0; k < 2; ++k) {
    proto::SubstrateSheet& huge = *c.mutable_hyperneat()->add_hidden_sheet();
    huge.set_columns(1000);
    huge.set_rows(1000);
  }
  EXPECT_FALSE(Population::create(c, 28, 7, 1)) << "a million millions of links";
}

}  // namespace
}  // namespace evograsp::neat

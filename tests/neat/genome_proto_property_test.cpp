// A genome's message and the way back.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "common/digest.h"
#include "neat/express.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

// Every topology, feed-forward or recurrent, with disabled links, hidden nodes and biases of their own.
std::vector<Genome> evolved(std::uint32_t kind, bool recurrent) {
  proto::NeatConfig config = testing::lively(20);
  config.set_topology(static_cast<proto::Topology>(kind));
  config.set_recurrent(recurrent);
  config.set_add_node(0.6);
  config.set_add_connection(0.8);
  config.set_mutate_bias(0.5);
  auto population = Population::create(config, 9, 3, kind + 1).value();
  testing::evolve(population, 25);
  return {population.ask().begin(), population.ask().end()};
}

TEST(GenomeMessage, ComesBackAsItWasWithTheSameNetwork) {
  std::uint32_t hidden = 0, disabled = 0;
  for (const std::uint32_t kind :
       {proto::HIDDEN_LAYER, proto::DIRECT, proto::SPARSE, proto::UNCONNECTED, proto::FEATURES})
    for (const bool recurrent : {false, true}) {
      proto::NeatConfig config;
      config.set_recurrent(recurrent);
      for (const Genome& genome : evolved(kind, recurrent)) {
        const std::string bytes = deterministic_bytes(to_proto(genome));
        proto::Genome message;
        ASSERT_TRUE(message.ParseFromString(bytes));
        const Result<Genome> back = from_proto(message, recurrent);
        ASSERT_TRUE(back) << back.error().message;
        EXPECT_EQ(deterministic_bytes(to_proto(*back)), bytes);
        EXPECT_EQ(back->id(), genome.id());
        ASSERT_EQ(back->links(), genome.links());
        for (std::uint32_t i = 0; i < genome.links(); ++i) {
          ASSERT_EQ(back->link(i), genome.link(i));
          disabled += !genome.enabled(i);
        }
        EXPECT_EQ(deterministic_bytes(express_proto(*back, config)),
                  deterministic_bytes(express_proto(genome, config)));
        hidden += genome.hidden_nodes();
      }
    }
  EXPECT_GT(hidden, 1000u) << "nothing was tried";
  EXPECT_GT(disabled, 1000u) << "nothing was tried";
}

// Inputs 0 and 1, bias 2, output 3, hidden 5 and 8: 0 -> 5 -> 8 -> 3.
proto::Genome small() {
  proto::Genome message;
  message.set_version(1);
  message.set_id(77);
  message.set_inputs(2);
  message.set_outputs(1);
  for (const std::uint32_t node : {3u, 5u, 8u}) {
    message.add_node_id(node);
    message.add_node_activation(static_cast<std::uint32_t>(Activation::kTanh));
    message.add_node_bias(0.25f);
  }
  const std::uint32_t links[][3] = {{4, 0, 5}, {9, 5, 8}, {10, 8, 3}};
  for (const auto& [innovation, source, target] : links) {
    message.add_innovation(innovation);
    message.add_source(source);
    message.add_target(target);
    message.add_weight(0.5f);
  }
  message.set_enabled("\x05");
  return message;
}

TEST(GenomeMessage, RefusesWhatCannotBeWithItsReason) {
  ASSERT_TRUE(from_proto(small(), false));
  using Change = std::function<void(proto::Genome&)>;
  const std::pair<Change, std::string> refused[] = {
      {[](auto& g) { g.set_inputs(0); }, "inputs and outputs"},
      {[](auto& g) { g.set_outputs(4'000'000'000u); }, "inputs and outputs"},
      {[](auto& g) { g.set_outputs(4); }, "lack outputs"},
      {[](auto& g) { g.add_node_bias(0); }, "node columns"},
      {[](auto& g) { g.mutable_node_activation()->RemoveLast(); }, "node columns"},
      {[](auto& g) { g.set_node_activation(1, 200); }, "unknown activation"},
      {[](auto& g) { g.set_node_id(0, 4); }, "outputs do not come first"},
      {[](auto& g) { g.set_node_id(2, 5); }, "hidden nodes must ascend"},
      {[](auto& g) { g.set_node_id(1, 2); }, "hidden nodes must ascend"},
      {[](auto& g) { g.set_node_id(2, 1u << 24); }, "number is too large"},
      {[](auto& g) { g.set_node_bias(1, std::nanf("")); }, "bias is not within"},
      {[](auto& g) { g.add_weight(0); }, "link columns"},
      {[](auto& g) { g.mutable_source()->RemoveLast(); }, "link columns"},
      {[](auto& g) { g.clear_enabled(); }, "link columns"},
      {[](auto& g) { g.set_innovation(1, 4); }, "innovations must ascend"},
      {[](auto& g) { g.set_innovation(1, 11); }, "innovations must ascend"},
      {[](auto& g) { g.set_innovation(0, 0); }, "innovations must ascend"},
      {[](auto& g) { g.set_source(1, 6); }, "no such source"},
      {[](auto& g) { g.set_target(1, 7); }, "no such target"},
      {[](auto& g) { g.set_target(1, 1); }, "no such target"},
      {[](auto& g) { g.set_source(1, 5 + (1u << 24)); }, "no such node"},
      {[](auto& g) { g.set_weight(2, std::numeric_limits<float>::infinity()); }, "weight is not within"},
      {[](auto& g) { g.set_weight(2, std::nanf("")); }, "weight is not within"},
      {[](auto& g) { g.set_source(1, 0), g.set_target(1, 5); }, "is double"},
      {[](auto& g) { g.set_source(0, 8); }, "cycle"},
  };
  for (const auto& [change, reason] : refused) {
    proto::Genome message = small();
    change(message);
    const Result<Genome> genome = from_proto(message, false);
    ASSERT_FALSE(genome) << reason;
    EXPECT_EQ(genome.error().code, ErrorCode::kInvalid) << reason;
    EXPECT_NE(genome.error().message.find(reason), std::string::npos) << genome.error().message;
    EXPECT_NE(genome.error().message.find("genome 77"), std::string::npos) << genome.error().message;
  }
  proto::Genome message = small();
  message.set_source(0, 8);
  EXPECT_TRUE(from_proto(message, true)) << "a recurrent genome may hold a cycle";
  message = small();
  message.set_version(2);
  const Result<Genome> later = from_proto(message, false);
  ASSERT_FALSE(later);
  EXPECT_EQ(later.error().code, ErrorCode::kUnsupported);
}

TEST(GenomeMessage, DamagedBytesAreRefusedOrSound) {
  Random random(3, Purpose::kTestHarness);
  int sound = 0, refused = 0;
  for (const Genome& original : evolved(proto::SPARSE, false)) {
    const std::string good = deterministic_bytes(to_proto(original));
    for (int t = 0; t < 300; ++t) {
      std::string bytes = good;
      for (std::uint32_t k = 0; k <= random.below(3); ++k) {
        const std::uint32_t at = random.below(static_cast<std::uint32_t>(bytes.size()));
        bytes[at] = static_cast<char>(random.below(256));
      }
      proto::Genome message;
      if (!message.ParseFromString(bytes)) continue;
      const Result<Genome> genome = from_proto(message, false);
      if (!genome) {
        ++refused;
        continue;
      }
      ++sound;
      ASSERT_TRUE(check(*genome, false));
      ASSERT_TRUE(Network::from_proto(express_proto(*genome, proto::NeatConfig())));
    }
  }
  EXPECT_GT(sound, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace evograsp::neat

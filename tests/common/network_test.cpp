#include "common/network.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "common/isa.h"
#include "common/random.h"

namespace evograsp {
namespace {

// A network of random shape: each computed node reads a random set of earlier nodes (any nodes when
// recurrent).
proto::Network random_network(Random& random, std::uint32_t inputs, std::uint32_t nodes, double density,
                              bool recurrent, std::uint32_t outputs = 3) {
  proto::Network proto;
  proto.set_inputs(inputs);
  proto.set_outputs(outputs);
  proto.set_recurrent(recurrent);
  proto.add_first_link(0);
  for (std::uint32_t i = 0; i < nodes; ++i) {
    const std::uint32_t limit = inputs + 1 + (recurrent ? nodes : i);
    for (std::uint32_t s = 0; s < limit; ++s) {
      if (!random.chance(density)) continue;
      proto.add_source(s);
      proto.add_weight(static_cast<float>(random.uniform(-2, 2)));
    }
    proto.add_first_link(static_cast<std::uint32_t>(proto.source_size()));
    proto.add_activation(random.below(8));
    proto.add_bias(static_cast<float>(random.uniform(-1, 1)));
  }
  for (std::uint32_t o = 0; o < outputs; ++o) proto.add_output_node(inputs + 1 + nodes - 1 - o);
  return proto;
}

std::vector<float> random_inputs(Random& random, std::size_t count) {
  std::vector<float> in(count);
  for (float& x : in) x = static_cast<float>(random.uniform(-1, 1));
  return in;
}

std::vector<std::uint32_t> bits(std::span<const float> values) {
  std::vector<std::uint32_t> result;
  for (const float v : values) result.push_back(std::bit_cast<std::uint32_t>(v));
  return result;
}

double exact(std::uint32_t f, double x) {
  switch (f) {
    case proto::STEEP_SIGMOID:
      return 1 / (1 + std::exp(-4.9 * x));
    case proto::TANH:
      return std::tanh(x);
    case proto::RELU:
      return std::max(x, 0.0);
    case proto::LINEAR:
      return x;
    case proto::SINE:
      return std::sin(x);
    case proto::GAUSSIAN:
      return std::exp(-x * x);
    case proto::ABS:
      return std::fabs(x);
    default:
      return x > 0 ? 1 : 0;
  }
}

// The definition, in double precision.
std::vector<double> by_definition(const proto::Network& net, std::span<const float> in, int steps) {
  const std::size_t inputs = net.inputs();
  std::vector<double> value(inputs + 1 + static_cast<std::size_t>(net.activation_size()), 0.0);
  std::copy(in.begin(), in.end(), value.begin());
  value[inputs] = 1;
  std::vector<double> old = value;
  for (int s = 0; s < (net.recurrent() ? steps : 1); ++s) {
    for (int i = 0; i < net.activation_size(); ++i) {
      double sum = static_cast<double>(net.bias(i));
      for (auto k = static_cast<int>(net.first_link(i)); k < static_cast<int>(net.first_link(i + 1)); ++k)
        sum += static_cast<double>(net.weight(k)) * (net.recurrent() ? old : value)[net.source(k)];
      value[inputs + 1 + static_cast<std::size_t>(i)] = exact(net.activation(i), sum);
    }
    old = value;
  }
  std::vector<double> out;
  for (const auto node : net.output_node()) out.push_back(value[node]);
  return out;
}

Network compiled(const proto::Network& proto) {
  auto network = Network::from_proto(proto);
  EXPECT_TRUE(network) << network.error().message;
  return std::move(*network);
}

TEST(Network, ComputesWhatTheDefinitionSays) {
  Random random(1, Purpose::kTestHarness);
  for (int trial = 0; trial < 200; ++trial) {
    const bool recurrent = trial % 3 == 0;
    const std::uint32_t inputs = 1 + random.below(40), nodes = 3 + random.below(20);
    const double density = random.uniform();
    proto::Network proto = random_network(random, inputs, nodes, density, recurrent);
    // Steps jump, and steep functions amplify rounding: leave those to the bit tests.
    for (int i = 0; i < proto.activation_size(); ++i)
      proto.set_activation(i, random.chance(0.5) ? proto::TANH : proto::GAUSSIAN);
    const std::vector<float> in = random_inputs(random, proto.inputs());
    const Network network = compiled(proto);
    Network::Scratch scratch;
    std::vector<float> out(3);
    network.activate(in, out, scratch, 2);
    const std::vector<double> expected = by_definition(proto, in, 2);
    for (int o = 0; o < 3; ++o) EXPECT_NEAR(out[o], expected[o], 1e-3) << "trial " << trial;
  }
}

TEST(Network, SingleBatchAndColumnsGiveTheSameBitsWithEveryInstructionSet) {
  Random random(2, Purpose::kTestHarness);
  for (int trial = 0; trial < 60; ++trial) {
    const bool recurrent = trial % 4 == 0;
    const std::uint32_t inputs = 1 + random.below(330), nodes = 3 + random.below(40);
    const double density = random.uniform();
    const proto::Network proto = random_network(random, inputs, nodes, density, recurrent);
    const Network network = compiled(proto);
    constexpr std::size_t kColumns = Network::kColumns, kCount = kColumns + 5;
    const std::vector<float> in = random_inputs(random, kCount * inputs);
    std::vector<std::uint32_t> first;
    for (const Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}) {
      if (!runs_here(isa)) continue;
      force_isa(isa);
      Network::Scratch scratch;
      std::vector<float> single(kCount * 3), batch(kCount * 3), columns(kColumns * 3),
          columns_in(kColumns * inputs);
      for (std::size_t r = 0; r < kCount; ++r)
        network.activate(std::span(in).subspan(r * inputs, inputs), std::span(single).subspan(r * 3, 3),
                         scratch, 3);
      network.activate_batch(in, batch, kCount, scratch, 3);
      for (std::size_t c = 0; c < kColumns; ++c)
        for (std::size_t i = 0; i < inputs; ++i) columns_in[i * kColumns + c] = in[c * inputs + i];
      network.activate_columns(columns_in, columns, scratch, 3);
      if (first.empty()) first = bits(single);
      EXPECT_EQ(bits(single), first) << name(isa) << ", trial " << trial;
      EXPECT_EQ(bits(batch), first) << name(isa) << ", batch, trial " << trial;
      for (std::size_t c = 0; c < kColumns; ++c)
        for (std::size_t o = 0; o < 3; ++o)
          ASSERT_EQ(std::bit_cast<std::uint32_t>(columns[o * kColumns + c]), first[c * 3 + o])
              << name(isa) << ", columns";
    }
  }
}

TEST(Network, RoundTripsThroughItsProto) {
  Random random(3, Purpose::kTestHarness);
  for (int trial = 0; trial < 20; ++trial) {
    const proto::Network proto = random_network(random, 7, 12, 0.5, trial % 2 == 0);
    const proto::Network again = compiled(proto).to_proto();
    EXPECT_EQ(compiled(again).to_proto().SerializeAsString(), again.SerializeAsString());
    EXPECT_EQ(again.source_size(), proto.source_size());
  }
}

TEST(Network, AnInputThatIsNotFiniteMakesEveryOutputNan) {
  Random random(4, Purpose::kTestHarness);
  const Network network = compiled(random_network(random, 20, 10, 0.5, false));
  Network::Scratch scratch;
  for (const float poison :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::vector<float> in = random_inputs(random, 16 * 20), out(16 * 3), clean(16 * 3);
    network.activate_batch(in, clean, 16, scratch);
    in[5 * 20 + 7] = poison;
    network.activate_batch(in, out, 16, scratch);
    for (std::size_t r = 0; r < 16; ++r)
      for (std::size_t o = 0; o < 3; ++o)
        EXPECT_TRUE(r == 5 ? std::isnan(out[r * 3 + o]) : out[r * 3 + o] == clean[r * 3 + o]);
  }
}

TEST(Network, StaysFiniteWhereLinksOnlyGrow) {
  proto::Network proto;  // a chain of linear nodes, each a million times the last
  proto.set_inputs(1);
  proto.set_outputs(1);
  proto.add_first_link(0);
  for (std::uint32_t i = 0; i < 60; ++i) {
    proto.add_activation(proto::LINEAR);
    proto.add_bias(0);
    proto.add_source(i == 0 ? 0 : i + 1);
    proto.add_weight(0x1p20f);
    proto.add_first_link(i + 1);
  }
  proto.add_output_node(61);
  Network::Scratch scratch;
  const float in = 3;
  float out = 0;
  compiled(proto).activate({&in, 1}, {&out, 1}, scratch);
  EXPECT_EQ(out, 0x1p64f);
}

TEST(Network, ScratchMayServeNetworksOfAnySizeInAnyOrder) {
  Random random(5, Purpose::kTestHarness);
  Network::Scratch shared;
  for (int trial = 0; trial < 30; ++trial) {
    const std::uint32_t inputs = 1 + random.below(100), nodes = 4 + random.below(50);
    const proto::Network proto = random_network(random, inputs, nodes, 0.3, trial % 2 == 0);
    const Network network = compiled(proto);
    const std::vector<float> in = random_inputs(random, proto.inputs());
    std::vector<float> a(3), b(3);
    Network::Scratch fresh;
    network.activate(in, a, shared, 2);
    network.activate(in, b, fresh, 2);
    EXPECT_EQ(bits(a), bits(b));
  }
}

TEST(Network, RefusesWhatIsNoNetworkAndSaysWhy) {
  Random random(6, Purpose::kTestHarness);
  const proto::Network good = random_network(random, 5, 6, 0.8, false);
  ASSERT_TRUE(Network::from_proto(good));
  const auto refused = [&](const std::function<void(proto::Network&)>& damage, const char* reason) {
    proto::Network bad = good;
    damage(bad);
    const auto result = Network::from_proto(bad);
    ASSERT_FALSE(result) << reason;
    EXPECT_NE(result.error().message.find(reason), std::string::npos) << result.error().message;
  };
  refused([](auto& n) { n.set_version(2); }, "version");
  refused([](auto& n) { n.set_inputs(0); }, "inputs");
  refused([](auto& n) { n.set_inputs(4'000'000'000u); }, "inputs");
  refused([](auto& n) { n.set_outputs(2); }, "output_node");
  refused([](auto& n) { n.clear_output_node(), n.set_outputs(0); }, "outputs");
  refused([](auto& n) { n.add_bias(1); }, "bias");
  refused([](auto& n) { n.set_bias(0, std::nanf("")); }, "bias");
  refused([](auto& n) { n.set_activation(1, 8); }, "activation");
  refused([](auto& n) { n.set_activation(1, 300); }, "activation");
  refused([](auto& n) { n.clear_first_link(); }, "first_link");
  refused([](auto& n) { n.set_first_link(2, 4'000'000'000u); }, "first_link");
  refused([](auto& n) { n.set_first_link(1, n.first_link(2) + 1); }, "network: node 0");
  refused([](auto& n) { n.add_weight(1); }, "weight");
  refused([](auto& n) { n.set_weight(3, std::numeric_limits<float>::infinity()); }, "weight");
  refused([](auto& n) { n.set_source(0, n.source(1)); }, "ascend");
  refused([](auto& n) { n.set_source(static_cast<int>(n.first_link(3)) - 1, 11); }, "after its target");
  refused([](auto& n) { n.set_recurrent(true), n.set_source(n.source_size() - 1, 12); }, "does not exist");
  refused([](auto& n) { n.set_output_node(0, 12); }, "output");
}

}  // namespace
}  // namespace evograsp

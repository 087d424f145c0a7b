#include "common/network_pack.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/digest.h"
#include "common/random.h"

namespace evograsp {
namespace {

proto::Network random_network(Random& random, std::uint32_t inputs, std::uint32_t nodes, double density,
                              bool recurrent) {
  proto::Network proto;
  proto.set_version(1);
  proto.set_inputs(inputs);
  proto.set_outputs(2);
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
  for (std::uint32_t o = 0; o < 2; ++o) proto.add_output_node(inputs + 1 + random.below(nodes));
  return proto;
}

// As it came out of the pack; what did not is an empty string, which no network is.
std::string there_and_back(const proto::Network& network) {
  const auto unpacked = unpack_network(pack_network(network));
  EXPECT_TRUE(unpacked) << (unpacked ? "" : unpacked.error().message);
  return unpacked ? deterministic_bytes(unpacked->to_proto()) : std::string();
}

TEST(NetworkPack, GivesBackTheSameBitsOfAnyNetwork) {
  Random random(1, Purpose::kTestHarness);
  for (int i = 0; i < 300; ++i) {
    const std::uint32_t inputs = 1 + random.below(400), nodes = 1 + random.below(20);
    const double density = random.uniform(0, 1);
    const bool recurrent = random.chance(0.3);
    const proto::Network network = random_network(random, inputs, nodes, density, recurrent);
    EXPECT_EQ(there_and_back(network), deterministic_bytes(network)) << i;
  }
}

TEST(NetworkPack, KeepsTheBitsOfEveryKindOfWeight) {
  proto::Network network;
  network.set_version(1);
  network.set_inputs(7);
  network.set_outputs(1);
  network.set_recurrent(false);
  network.add_first_link(0);
  using Limits = std::numeric_limits<float>;
  for (const float weight : {0.0f, -0.0f, Limits::denorm_min(), -Limits::denorm_min(), Limits::min(),
                             Network::kMaxWeight, -Network::kMaxWeight, 1.0f / 3}) {
    network.add_source(static_cast<std::uint32_t>(network.source_size()));
    network.add_weight(weight);
  }
  network.add_first_link(8);
  network.add_activation(proto::TANH);
  network.add_bias(0.25f);
  network.add_output_node(8);
  EXPECT_EQ(there_and_back(network), deterministic_bytes(network));
}

TEST(NetworkPack, ADenseNetworkTakesThreeAndAHalfBytesALink) {
  Random random(2, Purpose::kTestHarness);
  const proto::Network network = random_network(random, 311, 7, 1, false);
  EXPECT_LT(pack_network(network).size(), 3.5 * network.weight_size());
  EXPECT_GT(deterministic_bytes(network).size(), 5.6 * network.weight_size());
}

TEST(NetworkPack, RefusesDamagedBytesWithoutACrash) {
  Random random(3, Purpose::kTestHarness);
  const std::string good = pack_network(random_network(random, 40, 6, 0.7, false));
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(unpack_network(good.substr(0, size))) << size << " of " << good.size() << " bytes";
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = good;
    for (int flips = 1 + static_cast<int>(random.below(4)); flips > 0; --flips)
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] = static_cast<char>(random.below(256));
    const auto network = unpack_network(bytes);
    if (!network) continue;
    ++accepted;  // other weights: whatever is accepted is a sound network
    EXPECT_TRUE(Network::from_proto(network->to_proto()));
  }
  EXPECT_LT(accepted, 20000);
}

TEST(NetworkPack, BelievesNoCountItWouldHaveToAllocateFor) {
  // format 1; inputs 1, feed-forward, 2^32 - 1 nodes, links and outputs, nothing packed
  const std::string huge = "\x01\x01" + std::string(1, '\0') +
                           "\xff\xff\xff\xff\x0f\xff\xff\xff\xff\x0f\xff\xff\xff\xff\x0f" +
                           std::string(1, '\0');
  const auto refused = unpack_network(huge);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "packed network: too large");
}

TEST(NetworkPack, StoredNetworksAreCheckedBeforeTheyTravel) {
  Random random(4, Purpose::kTestHarness);
  proto::Network network = random_network(random, 10, 3, 1, false);
  ASSERT_TRUE(pack_serialised(deterministic_bytes(network)));
  EXPECT_EQ(*pack_serialised(deterministic_bytes(network)), pack_network(network));
  network.set_source(0, 99);
  EXPECT_FALSE(pack_serialised(deterministic_bytes(network)));
  EXPECT_FALSE(pack_serialised("no protobuf"));
}

}  // namespace
}  // namespace evograsp

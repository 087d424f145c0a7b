// Activation is called millions of times a run: it may not touch the heap.
#include <gtest/gtest.h>

#include <vector>

#include "common/network.h"
#include "tests/count_allocations.h"

namespace evograsp {
namespace {

TEST(NetworkAllocation, NothingOnceTheScratchIsSized) {
  for (const bool recurrent : {false, true}) {
    proto::Network proto;
    proto.set_inputs(304);
    proto.set_outputs(1);
    proto.set_recurrent(recurrent);
    proto.add_activation(proto::TANH);
    proto.add_bias(0);
    for (std::uint32_t s = 0; s < 304; ++s) {
      proto.add_source(s);
      proto.add_weight(0.01f);
    }
    proto.add_first_link(0);
    proto.add_first_link(304);
    proto.add_output_node(305);
    const Network network = Network::from_proto(proto).value();
    std::vector<float> in(Network::kColumns * 304, 0.5f), out(Network::kColumns);
    Network::Scratch scratch;
    Network::State state;
    network.activate_batch(in, out, 20, scratch);
    network.activate_columns(in, out, scratch);
    network.step(std::span(in).first(304), std::span(out).first(1), state);
    const std::uint64_t before = testing::allocations();
    for (int k = 0; k < 100; ++k) {
      network.activate(std::span(in).first(304), std::span(out).first(1), scratch, 2);
      network.activate_batch(in, out, 20, scratch, 2);
      network.activate_columns(in, out, scratch, 2);
      network.step(std::span(in).first(304), std::span(out).first(1), state);
    }
    EXPECT_EQ(testing::allocations(), before);
  }
  EXPECT_GT(testing::allocations(), 0u) << "the counter counts";
}

}  // namespace
}  // namespace evograsp

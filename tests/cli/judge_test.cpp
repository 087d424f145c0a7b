// Judging a champion: rates, their confidence, and independence of threads.
#include "cli/judge.h"

#include <gtest/gtest.h>

#include "assets/assets.h"
#include "common/config.h"
#include "sim/simulator.h"

namespace evograsp::cli {
namespace {

// Answers the same whatever it sees: each output is tanh of a bias link.
Network constant_network(int inputs, const std::vector<float>& weights) {
  proto::Network network;
  network.set_inputs(static_cast<std::uint32_t>(inputs));
  network.set_outputs(static_cast<std::uint32_t>(weights.size()));
  network.add_first_link(0);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    network.add_activation(proto::TANH);
    network.add_bias(0);
    network.add_source(static_cast<std::uint32_t>(inputs));  // the bias node
    network.add_weight(weights[i]);
    network.add_first_link(static_cast<std::uint32_t>(i + 1));
    network.add_output_node(static_cast<std::uint32_t>(inputs + 1 + i));
  }
  return Network::from_proto(network).value();
}

std::shared_ptr<const sim::Simulator> simulator_of(const std::string& object) {
  const auto loaded = load_config("quick", {"scene.object=" + object});
  const auto experiment = assets::resolve_experiment(loaded->config, {});
  return sim::Simulator::create(experiment->experiment, experiment->objects, experiment->hand).value();
}

TEST(Wilson, MatchesValuesComputedByHand) {
  // n = 10, 5 successes: centre 0.5, half width 1.96 / (1 + 0.38415) x sqrt(0.025 + 0.0096037) = 0.26341.
  EXPECT_NEAR(wilson(5, 10).low, 0.23659, 1e-5);
  EXPECT_NEAR(wilson(5, 10).high, 0.76341, 1e-5);
  // No failure in n: [n / (n + z^2), 1].
  EXPECT_NEAR(wilson(100, 100).low, 100 / 103.84146, 1e-6);
  EXPECT_EQ(wilson(100, 100).high, 1);
  EXPECT_EQ(wilson(0, 100).low, 0);
  EXPECT_EQ(wilson(0, 0).low, 0);
  EXPECT_EQ(wilson(0, 0).high, 1);
}

TEST(Judge, TheAnswerDoesNotDependOnThreads) {
  const auto simulator = simulator_of("cylinder");
  // Tilted, tool point near the object: closes on some placements and misses others.
  const Network network = constant_network(simulator->inputs(), {0, 0, 0.1f, 0, 1, 0, 0.3f});
  JudgeOptions options;
  options.placements = 60;
  options.lift = false;
  options.threads = 1;
  const Judgement one = judge(network, *simulator, 0, options).value();
  options.threads = 3;
  const Judgement three = judge(network, *simulator, 0, options).value();
  EXPECT_EQ(one.n, 60);
  EXPECT_EQ(one.successes, three.successes);
  EXPECT_EQ(one.unseen, three.unseen);
  EXPECT_LE(one.successes, one.n);
}

TEST(Judge, ANetworkThatAsksForThePoleNeverGrasps) {
  const auto simulator = simulator_of("cylinder");
  const Network network =
      constant_network(simulator->inputs(), {8, 8, 8, 0, 0, 0, 0});  // the far upper corner
  JudgeOptions options;
  options.placements = 20;
  const Judgement result = judge(network, *simulator, 0, options).value();
  EXPECT_EQ(result.n, 20);
  EXPECT_EQ(result.successes, 0);
  EXPECT_EQ(result.lifts, 0);
}

TEST(Judge, RefusesANetworkOfAnotherSize) {
  const auto simulator = simulator_of("cylinder");
  const auto result = judge(constant_network(10, {0, 0, 0, 0, 0, 0, 0}), *simulator, 0, {});
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().message, "the network has 10 inputs, the experiment gives 304");
}

}  // namespace
}  // namespace evograsp::cli

// A warm trial takes no memory: the hottest loop of the product must not wait for an allocator.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/network.h"
#include "tests/count_allocations.h"
#include "tests/sim/contact_sets.h"
#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

// Outputs that follow the inputs a little: the hand comes from another side to every object.
Network steering_network(int inputs) {
  proto::Network proto;
  proto.set_inputs(static_cast<std::uint32_t>(inputs));
  proto.set_outputs(kOutputs);
  Random random(3, Purpose::kTestHarness);
  proto.add_first_link(0);
  for (std::uint32_t o = 0; o < kOutputs; ++o) {
    proto.add_activation(proto::TANH);
    proto.add_bias(0);
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(inputs); ++i) {
      proto.add_source(i);
      proto.add_weight(static_cast<float>(random.uniform(-0.01, 0.01)));
    }
    proto.add_first_link((o + 1) * static_cast<std::uint32_t>(inputs));
    proto.add_output_node(static_cast<std::uint32_t>(inputs) + 1 + o);
  }
  return Network::from_proto(proto).value();
}

TEST(Allocation, AWarmTrialTakesNone) {
  const auto sim = testing::make_simulator({"cylinder", "cube", "sphere", "mug"});
  const auto workspace = sim->make_workspace();
  std::vector<testing::Trial> trials;
  for (std::uint64_t i = 0; i < 500; ++i) trials.push_back(testing::random_trial(*sim, i));
  const auto run = [&] {
    double sum = 0;
    for (const testing::Trial& t : trials)
      sum += sim->get_quality(t.placements, t.target, t.tool, *workspace).quality;
    return sum;
  };
  const double first = run();
  const std::uint64_t before = evograsp::testing::allocations();
  const double second = run();
  EXPECT_EQ(evograsp::testing::allocations() - before, 0u) << "in " << trials.size() << " trials";
  EXPECT_EQ(first, second);
  EXPECT_GT(before, 0u) << "the counter counts";
}

// From the network's inputs to the measurement: what a slot does again and again.
void expect_none(const std::vector<std::string>& objects, const std::string& hand,
                 const proto::Config& config) {
  const auto sim = testing::make_simulator(objects, hand, config);
  const auto workspace = sim->make_workspace();
  const Network network = steering_network(sim->inputs());
  Network::Scratch scratch;
  struct Task {
    testing::Trial trial;
    Info info;
    std::vector<float> inputs;
  };
  std::vector<Task> tasks;
  for (std::uint64_t seed = 0; tasks.size() < 200; ++seed) {
    ASSERT_LT(seed, 1000u) << "targets are never seen";
    Task task{testing::random_trial(*sim, seed), {}, {}};
    task.trial.target = static_cast<int>(
        std::find(task.trial.placements.present.begin(), task.trial.placements.present.end(), 1) -
        task.trial.placements.present.begin());
    auto info = sim->get_info(task.trial.placements, task.trial.target, 0, true);
    if (!info) continue;
    task.info = std::move(*info);
    task.inputs.resize(static_cast<std::size_t>(sim->inputs()));
    task.info.write_inputs(task.inputs);
    tasks.push_back(std::move(task));
  }
  int reached = 0;
  const auto run = [&] {
    double sum = 0;
    float outputs[kOutputs];
    for (const Task& task : tasks) {
      network.activate(task.inputs, outputs, scratch, 1);
      const Pose tool = sim->decode(outputs, task.info, true);
      const Measurement m = sim->get_quality(task.trial.placements, task.trial.target, tool, *workspace);
      const Measurement n =
          sim->get_quality(task.trial.placements, task.trial.target, task.trial.tool, *workspace);
      sum += m.quality + m.target_distance + n.quality + n.target_distance;
      reached += m.contacts + n.contacts > 0 ? 1 : 0;
    }
    return sum;
  };
  const double first = run();
  const std::uint64_t before = evograsp::testing::allocations();
  const double second = run();
  EXPECT_EQ(evograsp::testing::allocations() - before, 0u) << objects[0] << " with " << hand;
  EXPECT_EQ(first, second);
  EXPECT_GT(reached, 20) << objects[0] << " with " << hand << ": hardly anything was touched";
}

TEST(Allocation, AWarmTrialOfAnyKindTakesNone) {
  proto::Config plain, varied;
  varied.mutable_scene()->set_objects_in_scene(2);
  varied.mutable_scene()->set_size_jitter(0.3);
  varied.mutable_scene()->set_friction_jitter(0.3);
  expect_none({"cup"}, "meka_h2", plain);
  expect_none({"cube", "mug"}, "barrett", plain);
  expect_none({"cube_5cm"}, "parallel_jaw", plain);
  expect_none({"cylinder", "cube", "bottle", "mug"}, "meka_h2", varied);
}

TEST(Allocation, AWarmEpsilonTakesNone) {
  std::vector<std::vector<Wrench>> sets;
  for (int i = 0; i < 400; ++i)
    sets.push_back(testing::draw_wrenches(testing::kKinds[i % 4], 3 + i / 4 % 18, i));
  Epsilon epsilon;
  const auto run = [&] {
    double sum = 0;
    for (const auto& set : sets) sum += epsilon(set);
    return sum;
  };
  const double first = run();
  const std::uint64_t before = evograsp::testing::allocations();
  const double second = run();
  EXPECT_EQ(evograsp::testing::allocations() - before, 0u) << "in " << sets.size() << " sets";
  EXPECT_EQ(first, second);
  EXPECT_GT(first, 10) << "closed grasps among them";
}

}  // namespace
}  // namespace evograsp::sim

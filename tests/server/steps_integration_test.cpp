// The three commands across the wire give bit for bit what the library gives.
#include <gtest/gtest.h>

#include "common/step_client.h"
#include "sim/simulator.h"
#include "tests/server/cluster.h"
#include "worker/evaluator.h"

namespace evograsp {
namespace {

class Steps : public ::testing::Test {
 protected:
  void SetUp() override {
    server::ServerOptions options = testing::server_options(testing::small_config(1), dir_.path() / "run");
    experiment_ = options.experiment;
    server_ = std::move(*server::Server::create(options));
    endpoint_ = server_->endpoints()[0];
  }
  testing::TempDir dir_;
  assets::ResolvedExperiment experiment_;
  std::unique_ptr<server::Server> server_;
  std::string endpoint_;
};

TEST_F(Steps, AcrossTheWireIsWhatTheLibraryGives) {
  auto client = StepClient::connect(endpoint_, {});
  ASSERT_TRUE(client) << client.error().message;
  testing::WorkerThread worker(nullptr, endpoint_, 1);
  ASSERT_TRUE(testing::eventually([&] {
    proto::StepRequest probe;
    probe.mutable_shuffle()->set_seed(1);
    return client->ask(probe).has_value();
  }));
  const auto simulator =
      *sim::Simulator::create(experiment_.experiment, experiment_.objects, experiment_.hand);
  const auto workspace = simulator->make_workspace();

  proto::StepRequest shuffle;
  shuffle.mutable_shuffle()->set_seed(42);
  const auto placed = client->ask(shuffle);
  ASSERT_TRUE(placed) << placed.error().message;
  const auto placements = *simulator->shuffle(42);
  ASSERT_EQ(placed->placements().object_size(), 1);
  EXPECT_EQ(deterministic_bytes(placed->placements().object(0).pose()),
            deterministic_bytes(to_proto(placements.pose[0])));

  proto::StepRequest look;
  look.mutable_get_info()->set_target(0);
  const auto seen = client->ask(look);
  ASSERT_TRUE(seen) << seen.error().message;
  const auto info = *simulator->get_info(placements, 0, 0, true);
  EXPECT_TRUE(std::equal(info.depth.begin(), info.depth.end(), seen->info().depth().begin(),
                         seen->info().depth().end()));
  EXPECT_EQ(seen->info().click_a(), info.click_a);

  const std::vector<float> outputs = {0.1f, -0.2f, 0.05f, 0.3f, 0.2f, 0.9f, 0.4f};
  const Pose tool = simulator->decode(outputs, info, true);
  proto::StepRequest grasp;
  *grasp.mutable_get_quality()->mutable_pose() = to_proto(tool);
  const auto tried = client->ask(grasp);
  ASSERT_TRUE(tried) << tried.error().message;
  // The pose crosses as a quaternion: the library gets the same one.
  const Pose crossed = from_proto(grasp.get_quality().pose());
  EXPECT_EQ(
      deterministic_bytes(tried->grasp().measurement()),
      deterministic_bytes(worker::to_proto(simulator->get_quality(placements, 0, crossed, *workspace))));
}

TEST_F(Steps, WithoutAWorkerTheReasonIsGiven) {
  auto client = StepClient::connect(endpoint_, {});
  ASSERT_TRUE(client) << client.error().message;
  proto::StepRequest shuffle;
  shuffle.mutable_shuffle()->set_seed(1);
  const auto reply = client->ask(shuffle);
  ASSERT_FALSE(reply);
  EXPECT_NE(reply.error().message.find("no worker"), std::string::npos) << reply.error().message;
}

TEST_F(Steps, LookingBeforeShufflingIsAnError) {
  auto client = StepClient::connect(endpoint_, {});
  ASSERT_TRUE(client) << client.error().message;
  testing::WorkerThread worker(nullptr, endpoint_, 1);
  proto::StepRequest look;
  look.mutable_get_info()->set_target(0);
  std::string error;
  ASSERT_TRUE(testing::eventually([&] {
    const auto reply = client->ask(look);
    error = reply ? "" : reply.error().message;
    return error.find("no worker") == std::string::npos;
  }));
  EXPECT_NE(error.find("shuffle first"), std::string::npos) << error;
}

}  // namespace
}  // namespace evograsp

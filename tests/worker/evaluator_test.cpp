#include "worker/evaluator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace evograsp::worker {
namespace {

using ::testing::HasSubstr;

proto::TaskResult result_of(const proto::Task& task, std::size_t networks) {
  Evaluator evaluator(nullptr);
  std::vector<zmq::message_t> frames(networks);
  proto::TaskResult result;
  evaluator.evaluate(task, frames, result);
  return result;
}

proto::Task noop(int networks, int trials, double seconds) {
  proto::Task task;
  for (int i = 0; i < networks; ++i) task.add_network(1);
  for (int i = 0; i < trials; ++i) task.add_trial();
  task.set_noop_seconds(seconds);
  return task;
}

TEST(Evaluator, AnswersEveryTrialOrSaysWhyNot) {
  EXPECT_EQ(result_of(noop(2, 3, 0), 2).measurement_size(), 6);
  EXPECT_THAT(result_of(noop(2, 3, 0), 1).error(), HasSubstr("came with 1"));
}

// A task of a few megabytes could otherwise take gigabytes, or a slot for good.
TEST(Evaluator, RefusesTasksThatTakeTheWorker) {
  const proto::TaskResult many = result_of(noop(1000, 1000, 0), 1000);
  EXPECT_THAT(many.error(), HasSubstr("1000000 trials"));
  EXPECT_EQ(many.measurement_size(), 0);
  EXPECT_THAT(result_of(noop(1, 1, 1e9), 1).error(), HasSubstr("waits"));
  EXPECT_THAT(result_of(noop(1, 1, INFINITY), 1).error(), HasSubstr("waits"));
  EXPECT_THAT(result_of(noop(1, 1, NAN), 1).error(), HasSubstr("waits"));
}

}  // namespace
}  // namespace evograsp::worker

#include "common/task_memory.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "common/random.h"
#include "common/wire.h"

namespace evograsp {
namespace {

std::string bytes_of(std::uint64_t network) {
  return std::string(1 + network % 7, 'n') + std::to_string(network);
}

// A master that leaves out what its books say the worker has.
class Master {
 public:
  void begin(std::uint32_t trials) {
    trials_ = trials;
    begun_ = false;
  }
  proto::Task task(const std::vector<std::uint64_t>& networks, std::uint32_t first, std::uint32_t count,
                   std::vector<zmq::message_t>& body) {
    proto::Task task;
    task.set_first_trial(first);
    task.set_trials(count);
    if (!begun_) {
      has_.clear();
      for (std::uint32_t i = 0; i < trials_; ++i) task.add_trial()->set_seed(i);
    }
    begun_ = true;
    std::vector<std::uint64_t> sent;
    for (const std::uint64_t network : networks) {
      if (has_.has(network)) {
        task.add_known(static_cast<std::uint32_t>(task.network_size()));
        ++left_out;
      } else {
        body.push_back(to_frame(bytes_of(network)));
        sent.push_back(network);
      }
      task.add_network(network);
    }
    for (const std::uint64_t network : sent) has_.add(network, {}, bytes_of(network).size());
    return task;
  }
  int left_out = 0;

 private:
  NetworkMemory has_;
  std::uint32_t trials_ = 0;
  bool begun_ = false;
};

TEST(TaskMemory, MasterAndWorkerAgreeOnWhatIsKept) {
  Random random(1, Purpose::kTestHarness);
  Master master;
  TaskMemory worker;
  for (int round = 0; round < 2000; ++round) {
    if (round % 100 == 0) master.begin(1 + random.below(30));
    std::set<std::uint64_t> chosen;
    for (std::uint32_t i = 1 + random.below(6); i > 0; --i) chosen.insert(random.below(40));
    const std::vector<std::uint64_t> networks(chosen.begin(), chosen.end());
    std::vector<zmq::message_t> body;
    proto::Task task = master.task(networks, 0, 1, body);
    const Status status = worker.complete(task, body);
    ASSERT_TRUE(status) << status.error().message;
    ASSERT_EQ(body.size(), networks.size());
    for (std::size_t i = 0; i < body.size(); ++i)
      ASSERT_EQ(body[i].to_string(), bytes_of(networks[i])) << round;
  }
  EXPECT_GT(master.left_out, 500);
}

TEST(TaskMemory, GivesTheTrialsOfTheListThatATaskNames) {
  Master master;
  TaskMemory worker;
  master.begin(10);
  std::vector<zmq::message_t> body;
  proto::Task first = master.task({1}, 0, 4, body), second = master.task({1}, 4, 6, body);
  EXPECT_EQ(body.size(), 1U) << "the network went with the first task";
  ASSERT_TRUE(worker.complete(first, body));
  ASSERT_EQ(first.trial_size(), 4);
  body.clear();
  ASSERT_TRUE(worker.complete(second, body));
  ASSERT_EQ(second.trial_size(), 6);
  EXPECT_EQ(second.trial(0).seed(), 4U);
  EXPECT_EQ(second.trial(5).seed(), 9U);
}

TEST(TaskMemory, RefusesATaskThatBuildsOnWhatWasNeverSent) {
  const auto refused = [](proto::Task task, std::size_t frames) {
    TaskMemory worker;
    std::vector<zmq::message_t> body;
    for (std::size_t i = 0; i < frames; ++i) body.push_back(to_frame(std::string("n")));
    return !worker.complete(task, body);
  };
  proto::Task task;
  task.set_trials(1);
  task.add_network(1);
  EXPECT_TRUE(refused(task, 1)) << "no list of trials";
  task.add_trial();
  EXPECT_FALSE(refused(task, 1));
  EXPECT_TRUE(refused(task, 0));
  EXPECT_TRUE(refused(task, 2));
  task.set_first_trial(1);
  EXPECT_TRUE(refused(task, 1)) << "beyond the list";
  task.set_first_trial(4294967295U);
  EXPECT_TRUE(refused(task, 1)) << "an overflow";
  task.set_first_trial(0);
  task.add_known(0);
  EXPECT_TRUE(refused(task, 0)) << "a network of no earlier task";
  task.add_network(2);
  task.set_known(0, 7);
  EXPECT_TRUE(refused(task, 1)) << "a place that is none";
}

TEST(TaskMemory, KeepsFewNetworksAndFewBytes) {
  NetworkMemory memory;
  for (std::uint64_t i = 0; i < 100; ++i) memory.add(i, {}, 1);
  EXPECT_FALSE(memory.has(99 - NetworkMemory::kMostNetworks));
  EXPECT_TRUE(memory.has(100 - NetworkMemory::kMostNetworks));
  memory.add(100, {}, 2 * NetworkMemory::kMostBytes);
  EXPECT_TRUE(memory.has(100)) << "the newest always";
  EXPECT_FALSE(memory.has(99));
}

}  // namespace
}  // namespace evograsp

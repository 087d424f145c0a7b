// A trial is a pure function of experiment, pose and key: 10,000 of them give one digest in any order, on any
// thread, with any workspace.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <thread>

#include "tests/sim/digest.h"

namespace evograsp::sim {
namespace {

constexpr std::uint64_t kTrials = 10000;

class Purity : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    sim_ = testing::make_simulator({"cylinder", "cube", "sphere", "mug"});
    reference_ = run(in_order());
  }
  static void TearDownTestSuite() { sim_.reset(); }

  static std::vector<std::uint64_t> in_order() {
    std::vector<std::uint64_t> order(kTrials);
    std::iota(order.begin(), order.end(), 0);
    return order;
  }
  // The digest of each trial, by its index, after running them in `order` with one workspace.
  static std::vector<std::uint64_t> run(const std::vector<std::uint64_t>& order) {
    const auto workspace = sim_->make_workspace();
    std::vector<std::uint64_t> out(kTrials);
    for (const std::uint64_t i : order) out[i] = testing::digest_trial(*sim_, i, *workspace);
    return out;
  }

  static std::shared_ptr<const Simulator> sim_;
  static std::vector<std::uint64_t> reference_;
};

std::shared_ptr<const Simulator> Purity::sim_;
std::vector<std::uint64_t> Purity::reference_;

TEST_F(Purity, BackwardsIsTheSame) {
  std::vector<std::uint64_t> order = in_order();
  std::reverse(order.begin(), order.end());
  EXPECT_EQ(run(order), reference_);
}

TEST_F(Purity, ShuffledIsTheSame) {
  std::vector<std::uint64_t> order = in_order();
  Random random(3, Purpose::kTestHarness);
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  EXPECT_EQ(run(order), reference_);
}

TEST_F(Purity, FourThreadsOnOneSimulatorGiveTheSame) {
  std::vector<std::uint64_t> out(kTrials);
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < 4; ++t) {
    threads.emplace_back([&out, t] {
      const auto workspace = sim_->make_workspace();
      for (std::uint64_t i = t; i < kTrials; i += 4) out[i] = testing::digest_trial(*sim_, i, *workspace);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(out, reference_);
}

TEST_F(Purity, AFreshWorkspaceForEveryTrialGivesTheSame) {
  for (std::uint64_t i = 0; i < kTrials; i += 10) {
    const auto workspace = sim_->make_workspace();
    ASSERT_EQ(testing::digest_trial(*sim_, i, *workspace), reference_[i]) << "trial " << i;
  }
}

TEST_F(Purity, AFreshSimulatorGivesTheSame) {
  const auto other = testing::make_simulator({"cylinder", "cube", "sphere", "mug"});
  const auto workspace = other->make_workspace();
  for (std::uint64_t i = 0; i < kTrials; i += 10)
    ASSERT_EQ(testing::digest_trial(*other, i, *workspace), reference_[i]) << "trial " << i;
}

TEST_F(Purity, TheDigestSeesWhatIsMeasured) {
  std::vector<std::uint64_t> sorted = reference_;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(std::unique(sorted.begin(), sorted.end()), sorted.end()) << "different trials, equal digests";
}

}  // namespace
}  // namespace evograsp::sim

#include "server/footprint.h"

#include <gtest/gtest.h>

#include "neat/population.h"

namespace evograsp::server {
namespace {

class Footprint : public testing::Test {
 protected:
  void make(std::uint32_t size) {
    config_.mutable_neat()->set_population(size);
    auto made = neat::Population::create(config_.neat(), 100, 7, 1);
    ASSERT_TRUE(made);
    population_.emplace(std::move(*made));
  }
  proto::Config config_;
  std::optional<neat::Population> population_;
};

TEST_F(Footprint, GrowsWithTheGenerationAndIsNoLessThanItsGenomes) {
  make(10);
  const std::uint64_t small = footprint(population_->ask(), 20);
  EXPECT_GT(small, 10 * 2 * population_->ask()[0].bytes());
  EXPECT_GT(footprint(population_->ask(), 40), small);
  make(100);
  EXPECT_NEAR(static_cast<double>(footprint(population_->ask(), 20)), 10.0 * static_cast<double>(small),
              0.1 * 10 * static_cast<double>(small));
}

TEST_F(Footprint, SaysWhatDoesNotFitAndWhatToChange) {
  make(1000);
  config_.mutable_run()->set_memory_mb(1);
  const Status refused = check_footprint(config_, population_->ask(), 20, 1ULL << 40);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  EXPECT_NE(refused.error().message.find("1000 genomes"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("allowed are 1 (run.memory_mb)"), std::string::npos)
      << refused.error().message;
  config_.mutable_run()->set_memory_mb(4000);
  EXPECT_TRUE(check_footprint(config_, population_->ask(), 20, 1))
      << "what was asked for counts, not the machine";
}

TEST_F(Footprint, WithoutASettingTheMachineIsTheLimit) {
  make(1000);
  const std::uint64_t needed = footprint(population_->ask(), 20);
  EXPECT_TRUE(check_footprint(config_, population_->ask(), 20, needed / 3 * 4 + 8));
  EXPECT_FALSE(check_footprint(config_, population_->ask(), 20, needed));
  EXPECT_GT(machine_memory(), 100'000'000U);
}

}  // namespace
}  // namespace evograsp::server

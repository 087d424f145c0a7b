#include "server/footprint.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "neat/population.h"

namespace evograsp::server {
namespace {

class Footprint : public testing::Test {
 protected:
  void make(std::uint32_t size) {
    config_.set_population(size);
    auto made = neat::Population::create(config_, 100, 7, 1);
    ASSERT_TRUE(made);
    population_.emplace(std::move(*made));
  }
  proto::NeatConfig config_;
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
  const std::uint64_t needed = footprint(population_->ask(), 20);
  EXPECT_TRUE(check_footprint(population_->ask(), 20, needed));
  const Status refused = check_footprint(population_->ask(), 20, 1'000'000);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  const std::string& said = refused.error().message;
  EXPECT_NE(said.find("1000 genomes"), std::string::npos) << said;
  EXPECT_NE(said.find("allowed are 1 (EVOGRASP_MEMORY_MB"), std::string::npos) << said;
}

TEST_F(Footprint, TheLimitIsWhatWasAskedForOrTheMachines) {
  setenv("EVOGRASP_MEMORY_MB", "123", 1);
  EXPECT_EQ(memory_limit(), 123'000'000U);
  setenv("EVOGRASP_MEMORY_MB", "much", 1);
  const std::uint64_t machine = memory_limit();
  unsetenv("EVOGRASP_MEMORY_MB");
  EXPECT_EQ(memory_limit(), machine);
  EXPECT_GT(machine, 100'000'000U);
}

}  // namespace
}  // namespace evograsp::server

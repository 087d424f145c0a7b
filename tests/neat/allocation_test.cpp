// Storage: reproduction allocates nothing per gene, and genes are small.
#include <gtest/gtest.h>

#include "neat/mutation.h"
#include "neat/start.h"
#include "tests/count_allocations.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

// Allocations a child in generations 20 to 30 of 304 inputs into `hidden` nodes.
double allocations_a_child(std::uint32_t hidden) {
  proto::NeatConfig config;
  config.set_population(100);
  config.set_hidden(hidden);
  auto population = Population::create(config, 304, 7, 1).value();
  testing::evolve(population, 20);
  std::uint64_t sum = 0;
  for (int g = 0; g < 10; ++g) {
    const std::vector<double> fitness = testing::weigh(population.ask());
    const std::uint64_t before = evograsp::testing::allocations();
    population.tell(fitness);
    sum += evograsp::testing::allocations() - before;
  }
  return static_cast<double>(sum) / 1000;
}

TEST(Allocation, ReproductionAllocatesNothingPerGene) {
  const double few = allocations_a_child(1), many = allocations_a_child(16);
  EXPECT_GT(few, 0) << "the counter counts";
  EXPECT_LT(few, 12);
  EXPECT_LT(many, few + 4) << "sixteen times the genes";
}

TEST(Allocation, AGeneTakesAtMostSixteenBytes) {
  proto::NeatConfig config;
  config.set_population(100);
  auto population = Population::create(config, 304, 7, 1).value();
  testing::evolve(population, 100);
  for (const Genome& genome : population.ask()) EXPECT_LE(genome.bytes(), std::size_t{16} * genome.links());
}

// Hardly any link of the start: all that a gene costs is its own. Genes are links and hidden nodes.
TEST(Allocation, ALaterGeneTakesAtMostSixteenBytesToo) {
  proto::NeatConfig config;
  config.set_topology(proto::UNCONNECTED);
  for (const double splits : {0.0, 0.1, 1.0}) {
    const auto start = make_start(config, 100, 40);
    Random random(3, Purpose::kTestHarness);
    Genome genome = make_first(config, start, random);
    Innovations innovations(1, start->first_hidden());
    for (int t = 0; t < 4000; ++t) {
      innovations.next_generation();
      if (!random.chance(splits) || !add_node(genome, config, innovations, random))
        add_connection(genome, config, innovations, random);
      const std::size_t genes = genome.links() + genome.hidden_nodes();
      if (genes < 1000) continue;
      ASSERT_LE(genome.bytes(), 16 * genes) << genome.links() << " links";
    }
    EXPECT_GT(genome.links(), 2500u) << "large";
    EXPECT_EQ(genome.start_links(), 0u);
    EXPECT_TRUE(check(genome, false));
  }
}

}  // namespace
}  // namespace evograsp::neat

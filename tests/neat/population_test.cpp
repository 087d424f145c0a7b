#include "neat/population.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

using testing::evolve;
using testing::lively;
using testing::weigh;

Population make(const proto::NeatConfig& config, int inputs = 5, int outputs = 2, std::uint64_t seed = 1) {
  auto population = Population::create(config, inputs, outputs, seed);
  EXPECT_TRUE(population) << population.error().message;
  return std::move(*population);
}

TEST(Population, AsksForTheConfiguredNumberOfSoundGenomesEachGeneration) {
  Population population = make(lively());
  for (std::uint32_t g = 0; g < 20; ++g) {
    EXPECT_EQ(population.generation(), g);
    ASSERT_EQ(population.ask().size(), 60u);
    for (const Genome& genome : population.ask())
      ASSERT_TRUE(check(genome, false)) << check(genome, false).error().message;
    evolve(population, 1);
  }
}

TEST(Population, SelectionRaisesFitness) {
  Population population = make(lively(100));
  const auto mean = [&] {
    double sum = 0;
    for (const double f : weigh(population.ask())) sum += f;
    return sum / 100;
  };
  const double before = mean();
  evolve(population, 40);
  EXPECT_GT(mean(), before + 0.5);
}

TEST(Population, SavedAndLoadedContinuesToTheSameBytes) {
  Population one = make(lively());
  evolve(one, 7);
  auto two = Population::load(lively(), one.save());
  ASSERT_TRUE(two) << two.error().message;
  EXPECT_EQ(two->save(), one.save());
  EXPECT_EQ(two->species().size(), one.species().size());
  evolve(one, 8);
  evolve(*two, 8);
  EXPECT_EQ(two->save(), one.save());
}

TEST(Population, IdsAreUniqueAndChampionsKeepTheirs) {
  Population population = make(lively());
  std::set<std::uint64_t> known;
  for (int g = 0; g < 15; ++g) {
    std::set<std::uint64_t> now;
    for (const Genome& genome : population.ask())
      EXPECT_TRUE(now.insert(genome.id()).second) << "an id twice";
    known = now;
    const std::vector<double> fitness = weigh(population.ask());
    const auto best = std::max_element(fitness.begin(), fitness.end()) - fitness.begin();
    const Genome champion = population.ask()[static_cast<std::size_t>(best)];
    bool elite = false;
    for (const auto& members : population.members())
      for (const auto i : members) elite |= i == best && members.size() >= 5;
    population.tell(fitness);
    bool kept = false;
    for (const Genome& genome : population.ask()) kept |= genome.id() == champion.id() && genome == champion;
    EXPECT_EQ(kept, elite) << "generation " << g;
  }
}

TEST(Population, NotANumberAndInfinityAreTheWorstAndNeverBreedFirst) {
  Population population = make(lively());
  for (int g = 0; g < 5; ++g) {
    std::vector<double> fitness = weigh(population.ask());
    fitness[0] = std::nan("");
    fitness[1] = std::numeric_limits<double>::infinity();
    fitness[2] = -std::numeric_limits<double>::infinity();
    const std::uint64_t ids[] = {population.ask()[0].id(), population.ask()[1].id(),
                                 population.ask()[2].id()};
    population.tell(fitness);
    for (const Genome& genome : population.ask())
      for (const std::uint64_t id : ids)
        EXPECT_NE(genome.id(), id) << "an invalid genome was kept as champion";
    for (const SpeciesSummary& s : population.species())
      EXPECT_TRUE(std::isfinite(s.best) && std::isfinite(s.mean));
  }
}

TEST(Population, SurvivesFitnessThatSaysNothing) {
  for (const double value :
       {0.0, -3.0, std::nan(""), std::numeric_limits<double>::infinity(), 1e308, -1e308}) {
    Population population = make(lively());
    for (int g = 0; g < 45; ++g) {
      population.tell(std::vector<double>(60, value));
      ASSERT_EQ(population.ask().size(), 60u) << value;
      ASSERT_FALSE(population.members().empty());
    }
  }
}

TEST(Population, RefusesWhatContradictsItself) {
  proto::NeatConfig config = lively();
  EXPECT_FALSE(Population::create(config, 0, 2, 1));
  EXPECT_FALSE(Population::create(config, 3, -1, 1));
  config.set_hidden(10000);
  EXPECT_FALSE(Population::create(config, 1000, 7, 1)) << "ten million links";
  config = lively();
  config.set_max_weight(std::nan(""));
  EXPECT_FALSE(Population::create(config, 3, 2, 1));
}

}  // namespace
}  // namespace evograsp::neat

// Who breeds, who is kept and who belongs together. Genomes here have one link, and its weight is the
// genome's name: member i of group g weighs 1000 g + i. Unless a test says otherwise children are exact
// copies, so that a generation's names tell who its parents were; the threshold lies between groups.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "proto/population.pb.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

using Groups = std::map<int, std::uint32_t>;  // members, by group

proto::NeatConfig still() {
  proto::NeatConfig config;
  config.set_topology(proto::DIRECT);
  config.set_max_weight(1'000'000);
  for (const auto set : {&proto::NeatConfig::set_mutate_weights, &proto::NeatConfig::set_add_node,
                         &proto::NeatConfig::set_add_connection, &proto::NeatConfig::set_crossover,
                         &proto::NeatConfig::set_interspecies})
    (config.*set)(0);
  config.set_c3_weight(1);
  config.set_threshold(500);
  config.set_target_species(0);
  config.set_survival(1);
  config.set_drop_off_age(0);
  config.set_elite_min_size(0);
  return config;
}

// A population whose species are these groups, by way of its stored state.
Population settle(proto::NeatConfig config, const Groups& groups, std::uint64_t seed = 1) {
  std::uint32_t size = 0;
  for (const auto& [group, members] : groups) size += members;
  config.set_population(size);
  proto::PopulationState state;
  EXPECT_TRUE(state.ParseFromString(Population::create(config, 1, 1, seed).value().save()));
  state.clear_species();
  state.set_threshold(config.threshold());
  int next = 0;
  for (const auto& [group, members] : groups) {
    proto::SpeciesState& species = *state.add_species();
    species.set_id(static_cast<std::uint32_t>(state.species_size()));
    species.set_age(0), species.set_improved(0), species.set_best(0);
    for (std::uint32_t i = 0; i < members; ++i, ++next) {
      state.mutable_genome(next)->set_weight(0, static_cast<float>(1000 * group) + static_cast<float>(i));
      species.add_member(static_cast<std::uint32_t>(next));
    }
  }
  state.set_next_species(static_cast<std::uint32_t>(state.species_size()) + 1);
  auto population = Population::load(config, state.SerializeAsString());
  EXPECT_TRUE(population) << population.error().message;
  return std::move(*population);
}

double name(const Genome& genome) {
  return static_cast<double>(genome.weight(0));
}
int group(const Genome& genome) {
  return static_cast<int>(name(genome)) / 1000;
}

template <class Fitness>
void tell(Population& population, Fitness fitness) {
  std::vector<double> told;
  for (const Genome& genome : population.ask()) told.push_back(fitness(genome));
  population.tell(told);
}

Groups groups(const Population& population) {
  Groups result;
  for (const Genome& genome : population.ask()) ++result[group(genome)];
  return result;
}

std::set<int> alive(const Population& population) {
  std::set<int> result;
  for (const auto& [group, members] : groups(population)) result.insert(group);
  return result;
}

using Alive = std::set<int>;

TEST(Selection, ChildrenAreSharedOutByTheSpeciesMeanFitness) {
  Population population = settle(still(), {{0, 10}, {1, 4}, {2, 6}});
  tell(population, [](const Genome& g) { return group(g) == 0 ? 5.0 : group(g) == 1 ? 10.0 : 5.0; });
  EXPECT_EQ(groups(population), (Groups{{0, 5}, {1, 10}, {2, 5}})) << "not by their number";
}

TEST(Selection, ASpeciesThatHasNotImprovedForTwentyGenerationsDiesOutUnlessItIsTheBest) {
  proto::NeatConfig config = still();
  config.clear_drop_off_age();  // the paper's and the thesis's default
  Population population = settle(config, {{0, 10}, {1, 10}, {2, 10}, {3, 10}});
  const auto fitness = [&](const Genome& g) {
    const double usual[] = {5, 3, 4, 2};
    if (group(g) == 2) return 4.0 + 0.001 * population.generation();  // rises always
    if (group(g) == 3)
      return population.generation() == 9 ? 3.0 : 2.0;  // its record is of its tenth judgement
    return usual[group(g)];
  };
  for (int judged = 1; judged <= 20; ++judged) {
    tell(population, fitness);
    ASSERT_EQ(alive(population), (Alive{0, 1, 2, 3})) << "judged " << judged << " times";
  }
  tell(population, fitness);
  EXPECT_EQ(alive(population), (Alive{0, 2, 3})) << "its best was its first: 20 generations ago";
  for (int judged = 22; judged <= 29; ++judged) {
    tell(population, fitness);
    ASSERT_EQ(alive(population), (Alive{0, 2, 3})) << "judged " << judged << " times";
  }
  tell(population, fitness);
  EXPECT_EQ(alive(population), (Alive{0, 2})) << "20 generations after its record";
  for (int judged = 31; judged <= 60; ++judged) tell(population, fitness);
  EXPECT_EQ(alive(population), (Alive{0, 2})) << "the best stands still for 60 generations and is protected";
}

TEST(Selection, NobodyDiesOutOfAgeWhenThatIsOff) {
  Population population = settle(still(), {{0, 10}, {1, 10}});
  for (int judged = 0; judged < 60; ++judged)
    tell(population, [](const Genome& g) { return 5.0 - group(g); });
  EXPECT_EQ(alive(population), (Alive{0, 1}));
}

TEST(Selection, ParentsComeFromTheBestOfEachSpeciesAlone) {
  struct Case {
    double survival;
    std::uint32_t members, parents;  // ceil(survival members), at least one
  };
  for (const Case& c : {Case{0.2, 10, 2}, Case{0.3, 7, 3}, Case{0.01, 7, 1}, Case{0.5, 5, 3},
                        Case{0.75, 8, 6}, Case{1, 7, 7}})
    for (const double crossover : {0.0, 1.0}) {
      proto::NeatConfig config = still();
      config.set_survival(c.survival);
      config.set_crossover(crossover);
      std::set<double> parents, expected, others;
      for (std::uint64_t seed = 0; seed < 200; ++seed) {
        Population population = settle(config, {{0, c.members}, {1, c.members}}, seed);
        // Of group 1 all are worse than the worst of group 0.
        tell(population,
             [](const Genome& g) { return std::fmod(name(g), 1000) + (group(g) == 0 ? 200 : 100); });
        for (const Genome& g : population.ask()) (group(g) == 0 ? parents : others).insert(name(g));
      }
      for (std::uint32_t k = 1; k <= c.parents; ++k) expected.insert(c.members - k);
      EXPECT_EQ(parents, expected) << c.survival << " of " << c.members << ", crossover " << crossover;
      std::set<double> expected_others;
      for (const double best : expected) expected_others.insert(1000 + best);
      EXPECT_EQ(others, expected_others) << "each species by itself";
    }
}

TEST(Selection, MatesAreOfAnotherSpeciesAtTheirRate) {
  for (const double rate : {0.0, 0.25, 1.0}) {
    proto::NeatConfig config = still();
    config.set_crossover(1);
    config.set_mate_average(1);  // a child's name is the mean of its parents'
    config.set_interspecies(rate);
    std::map<int, int>
        pairs;  // by the sum of their groups: 0 + 0 = 0, 0 + 1 = 1, 1 + 1 = 2, 0 + 4, 1 + 4, 4 + 4
    int children = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      Population population = settle(config, {{0, 6}, {1, 6}, {4, 6}}, seed);
      tell(population, [](const Genome&) { return 1.0; });
      for (const Genome& g : population.ask()) ++pairs[static_cast<int>(2 * name(g)) / 1000], ++children;
    }
    ASSERT_EQ(children, 200 * 18);
    EXPECT_NEAR(pairs[1] + pairs[4] + pairs[5], rate * children, rate == 0.25 ? 110 : 0) << "rate " << rate;
    for (const int across : {1, 4, 5})
      EXPECT_NEAR(pairs[across], rate * children / 3, rate > 0 ? 120 : 0) << "each other species alike";
  }
}

TEST(Selection, OneSpeciesAloneMatesWithinItself) {
  proto::NeatConfig config = still();
  config.set_crossover(1);
  config.set_interspecies(1);
  Population population = settle(config, {{3, 8}});
  tell(population, [](const Genome&) { return 1.0; });
  EXPECT_EQ(alive(population), Alive{3});
}

TEST(Selection, RefocusLetsOnlyTheTwoBestSpeciesBreed) {
  proto::NeatConfig config = still();
  config.set_refocus_age(3);
  const Groups before = {{0, 6}, {1, 6}, {2, 6}, {3, 6}};
  const double usual[] = {2, 5, 3, 4};
  Population population = settle(config, before);
  for (int g = 0; g <= 3; ++g) {
    tell(population, [&](const Genome& genome) { return usual[group(genome)]; });
    ASSERT_EQ(alive(population), (Alive{0, 1, 2, 3})) << "no better best for " << g << " generations";
  }
  tell(population, [&](const Genome& genome) { return usual[group(genome)]; });
  EXPECT_EQ(groups(population), (Groups{{1, 12}, {3, 12}})) << "for more than 3: the best two, half each";

  Population rising = settle(config, before);
  for (int g = 0; g < 20; ++g)
    tell(rising, [&](const Genome& genome) { return usual[group(genome)] + 0.001 * (g / 3); });
  EXPECT_EQ(alive(rising), (Alive{0, 1, 2, 3})) << "the best rises every third generation";

  config.set_refocus_age(0);
  Population off = settle(config, before);
  for (int g = 0; g < 60; ++g) tell(off, [&](const Genome& genome) { return usual[group(genome)]; });
  EXPECT_EQ(alive(off), (Alive{0, 1, 2, 3}));
}

TEST(Selection, TheChampionOfEachSpeciesOfAtLeastFiveIsKeptUnchanged) {
  proto::NeatConfig config = still();
  config.clear_elite_min_size();
  config.set_mutate_weights(1);  // no other child is as its parent was
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Population population = settle(config, {{0, 5}, {1, 4}, {2, 6}, {3, 5}}, seed);
    const std::vector<Genome> before(population.ask().begin(), population.ask().end());
    tell(population, [](const Genome& g) { return 10 + group(g) - std::fabs(std::fmod(name(g), 1000) - 2); });
    std::map<double, int> kept;  // by name
    for (const Genome& g : population.ask()) {
      const auto old =
          std::find_if(before.begin(), before.end(), [&](const Genome& b) { return b.id() == g.id(); });
      const bool copy = std::any_of(before.begin(), before.end(), [&](const Genome& b) { return b == g; });
      EXPECT_EQ(old != before.end(), copy) << "kept with its id, or changed with another";
      if (old == before.end()) continue;
      EXPECT_TRUE(*old == g) << "an id means one genome";
      ++kept[name(g)];
    }
    EXPECT_EQ(kept, (std::map<double, int>{{2, 1}, {2002, 1}, {3002, 1}})) << "seed " << seed;
  }
}

TEST(Selection, NoChampionIsKeptWhenThatIsOff) {
  proto::NeatConfig config = still();
  config.set_mutate_weights(1);
  Population population = settle(config, {{0, 9}, {1, 9}});
  const std::uint64_t newest = 18;
  tell(population, [](const Genome& g) { return name(g); });
  for (const Genome& g : population.ask()) EXPECT_GT(g.id(), newest);
}

TEST(Selection, AFixedThresholdStaysWhateverTheNumberOfSpecies) {
  const Groups many = {{0, 2}, {1, 2}, {2, 2}, {3, 2}, {4, 2}, {5, 2}, {6, 2}, {7, 2}, {8, 2}, {9, 2}};
  for (const double threshold : {500.0, 0.5, 50'000.0}) {
    proto::NeatConfig config = still();
    config.set_threshold(threshold);
    Population population = settle(config, many);
    for (int g = 0; g < 5; ++g) {
      tell(population, [](const Genome&) { return 1.0; });
      EXPECT_EQ(population.threshold(), threshold);
      std::set<double> names;
      for (const Genome& genome : population.ask()) names.insert(name(genome));
      const std::size_t apart = threshold < 1        ? names.size()
                                : threshold < 10'000 ? alive(population).size()
                                                     : 1;
      EXPECT_EQ(population.members().size(), apart) << "threshold " << threshold;
    }
  }
}

TEST(Selection, ASteeredThresholdFollowsTheNumberOfSpecies) {
  const auto steered = [](std::uint32_t wanted, const Groups& groups, double threshold = 500) {
    proto::NeatConfig config = still();
    config.set_threshold(threshold);
    config.set_target_species(wanted);
    Population population = settle(config, groups);
    tell(population, [](const Genome&) { return 1.0; });
    return population;
  };
  EXPECT_DOUBLE_EQ(steered(3, {{0, 6}, {1, 6}, {2, 6}}).threshold(), 500.0) << "as wanted";
  EXPECT_DOUBLE_EQ(steered(4, {{0, 6}, {1, 6}, {2, 6}}).threshold(), 500.0 * (1 - 0.025))
      << "one of four missing";
  EXPECT_DOUBLE_EQ(steered(2, {{0, 6}, {1, 6}, {2, 6}}).threshold(), 500.0 * 1.05) << "by 5 percent at most";
  EXPECT_DOUBLE_EQ(steered(6, {{0, 6}, {1, 6}, {2, 6}}).threshold(), 500.0 * 0.97) << "by 3 percent at most";
  // More than twice as many as wanted: sorted again until there are not, whatever the threshold.
  const Population merged = steered(2, {{0, 2}, {1, 2}, {2, 2}, {3, 2}, {4, 2}, {5, 2}, {6, 2}, {7, 2}});
  EXPECT_GT(merged.threshold(), 1000);
  EXPECT_LE(merged.members().size(), 4u);
  // Fewer than half as many: the same, downwards.
  const Population split = steered(6, {{0, 6}, {1, 6}}, 10);
  EXPECT_LT(split.threshold(), 6) << "members of one group have to part";
  EXPECT_GE(split.members().size(), 3u);
}

}  // namespace
}  // namespace evograsp::neat

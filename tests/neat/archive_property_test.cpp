// What an archive may and may not do to evolution, whatever the config and the seed.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

using testing::lively;
using testing::weigh;

proto::NeatConfig with_archive(proto::ArchiveKind kind, std::uint32_t size = 40) {
  proto::NeatConfig config = lively(size);
  proto::ArchiveConfig& archive = *config.mutable_archive();
  archive.set_kind(kind);
  archive.mutable_x()->set_bins(6);
  archive.mutable_y()->set_bins(5);
  archive.set_remembered(2);
  archive.set_memory(30);
  return config;
}

// A behaviour that follows from the genome and the trials of the generation, as real ones do.
Behaviour behave(const Genome& genome, std::uint32_t generation) {
  Random noise(genome.id(), Purpose::kTestHarness, generation);
  if (noise.chance(0.05)) return {};
  const double a = static_cast<double>(genome.weight(0)), b = static_cast<double>(genome.weight(1));
  const double x = 0.5 + 0.1 * a + noise.uniform(-0.05, 0.05), y = 0.5 + 0.1 * b;
  return {x, y};
}

struct Told {
  std::vector<double> fitness;
  std::vector<Behaviour> behaviour;
};

Told judge(const Population& population) {
  Told told;
  for (const Genome& genome : population.ask()) {
    Random noise(genome.id(), Purpose::kTestHarness, population.generation(), 1);
    told.fitness.push_back(weigh(genome) + noise.uniform(-0.2, 0.2));
    told.behaviour.push_back(behave(genome, population.generation()));
  }
  return told;
}

void step(Population& population) {
  const Told told = judge(population);
  population.tell(told.fitness, told.behaviour);
}

Population make(const proto::NeatConfig& config, std::uint64_t seed) {
  return std::move(*Population::create(config, 5, 3, seed));
}

TEST(ArchiveLaws, WatchingChangesNothing) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    proto::NeatConfig watching = with_archive(proto::MAP_ELITES);
    watching.mutable_archive()->set_children(0);
    watching.mutable_archive()->set_again(0);
    Population plain = make(lively(40), seed), watched = make(watching, seed);
    for (int g = 0; g < 15; ++g) {
      plain.tell(judge(plain).fitness);
      step(watched);
      ASSERT_EQ(plain.ask().size(), watched.ask().size());
      for (std::size_t i = 0; i < plain.ask().size(); ++i)
        ASSERT_EQ(to_proto(plain.ask()[i]).SerializeAsString(),
                  to_proto(watched.ask()[i]).SerializeAsString())
            << "genome " << i << " of generation " << g + 1;
    }
    EXPECT_GT(watched.archive()->elites().size(), 3U);
  }
}

TEST(ArchiveLaws, ElitesOfAStillWorldOnlyImproveAndCellsStayFilled) {
  Population population = make(with_archive(proto::MAP_ELITES), 3);
  std::map<std::uint32_t, double> before;
  for (int g = 0; g < 40; ++g) {
    Told told;
    for (const Genome& genome : population.ask()) {
      told.fitness.push_back(weigh(genome));
      told.behaviour.push_back({0.5 + 0.1 * static_cast<double>(genome.weight(0)),
                                0.5 + 0.1 * static_cast<double>(genome.weight(1))});
    }
    population.tell(told.fitness, told.behaviour);
    const auto& elites = population.archive()->elites();
    for (const auto& [cell, fitness] : before) {
      ASSERT_TRUE(elites.contains(cell)) << "cell " << cell << " of generation " << g;
      ASSERT_GE(elites.at(cell).fitness(), fitness - 1e-9);
    }
    for (const auto& [cell, elite] : elites) before[cell] = elite.fitness();
  }
  EXPECT_GT(before.size(), 5U);
}

TEST(ArchiveLaws, PopulationsKeepTheirSizeAndEveryIdIsThereOnce) {
  for (const double children : {0.0, 0.3, 1.0}) {
    proto::NeatConfig config = with_archive(proto::MAP_ELITES);
    config.mutable_archive()->set_children(children);
    config.mutable_archive()->set_again(children == 1.0 ? 0 : 0.2);
    Population population = make(config, 7);
    for (int g = 0; g < 25; ++g) {
      step(population);
      std::set<std::uint64_t> ids;
      for (const Genome& genome : population.ask()) {
        ids.insert(genome.id());
        const Status sound = check(genome, false);
        ASSERT_TRUE(sound) << sound.error().message;
      }
      ASSERT_EQ(ids.size(), 40U) << "generation " << g << ", children " << children;
      for (const auto& [cell, elite] : population.archive()->elites())
        ASSERT_EQ(population.archive()->cell_of(elite.behaviour()), cell);
    }
  }
}

TEST(ArchiveLaws, ElitesAreJudgedAgain) {
  proto::NeatConfig config = with_archive(proto::MAP_ELITES);
  config.set_elite_min_size(0);  // NEAT itself keeps none
  config.mutable_archive()->set_again(0.3);
  Population population = make(config, 11);
  for (int g = 0; g < 20; ++g) step(population);
  std::uint32_t most = 0;
  for (const auto& [cell, elite] : population.archive()->elites()) most = std::max(most, elite.judged);
  EXPECT_GE(most, 3U);
}

TEST(ArchiveLaws, SavedAndLoadedAtAnyTimeItGoesOnToTheSameBytes) {
  for (const proto::ArchiveKind kind : {proto::MAP_ELITES, proto::NOVELTY}) {
    const proto::NeatConfig config = with_archive(kind);
    Population straight = make(config, 5), broken = make(config, 5);
    for (int g = 0; g < 20; ++g) {
      step(straight);
      step(broken);
      auto loaded = Population::load(config, broken.save());
      ASSERT_TRUE(loaded) << loaded.error().message;
      broken = std::move(*loaded);
    }
    EXPECT_EQ(straight.save(), broken.save());
    EXPECT_FALSE(straight.archive()->elites().empty());
    EXPECT_EQ(straight.archive()->memory().empty(), kind == proto::MAP_ELITES);
  }
}

TEST(ArchiveLaws, AfterLoadingTheWholeMapCountsAsChanged) {
  const proto::NeatConfig config = with_archive(proto::MAP_ELITES);
  Population population = make(config, 5);
  for (int g = 0; g < 10; ++g) step(population);
  Population loaded = std::move(*Population::load(config, population.save()));
  step(population);
  step(loaded);
  for (const auto& [cell, elite] : loaded.archive()->elites())
    EXPECT_TRUE(loaded.archive()->changed().contains(cell)) << cell;
  EXPECT_LT(population.archive()->changed().size(), loaded.archive()->changed().size());
}

// More of what was seldom done: the whole point. Without fitness to go by, selection by novelty fills more
// cells.
TEST(ArchiveLaws, NoveltyVisitsMoreCellsThanChance) {
  std::size_t novel = 0, plain = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    proto::NeatConfig config = with_archive(proto::NOVELTY, 60);
    config.mutable_archive()->mutable_x()->set_bins(16);
    config.mutable_archive()->mutable_y()->set_bins(16);
    for (const double weight : {0.0, 1.0}) {
      config.mutable_archive()->set_weight(weight);
      Population population = make(config, seed);
      for (int g = 0; g < 30; ++g) {
        Told told = judge(population);
        std::fill(told.fitness.begin(), told.fitness.end(), 1.0);
        population.tell(told.fitness, told.behaviour);
      }
      (weight > 0 ? novel : plain) += population.archive()->elites().size();
    }
  }
  EXPECT_GT(novel, plain + plain / 10) << "cells over six runs";
}

TEST(ArchiveLaws, DamagedStateIsRefused) {
  const proto::NeatConfig config = with_archive(proto::NOVELTY);
  Population population = make(config, 9);
  for (int g = 0; g < 6; ++g) step(population);
  const std::string state = population.save();
  EXPECT_FALSE(Population::load(lively(40), state)) << "an archive without the config's";
  EXPECT_FALSE(Population::load(config, make(lively(40), 9).save())) << "none with the config's";
  Random random(1, Purpose::kTestHarness);
  for (int k = 0; k < 3000; ++k) {  // must not crash; what loads must be able to go on
    std::string damaged = state;
    const std::uint32_t at = random.below(static_cast<std::uint32_t>(state.size()));
    damaged[at] = static_cast<char>(random.next());
    auto loaded = Population::load(config, damaged);
    if (loaded && k % 50 == 0) step(*loaded);
  }
}

}  // namespace
}  // namespace evograsp::neat

// The map of grasps and the memory of novelty, by cases worked out by hand.
#include "neat/archive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

proto::ArchiveConfig grid(std::uint32_t columns, std::uint32_t rows) {
  proto::ArchiveConfig config;
  config.mutable_x()->set_of(proto::PITCH);
  config.mutable_x()->set_bins(columns);
  config.mutable_y()->set_of(proto::HEIGHT);
  config.mutable_y()->set_bins(rows);
  return config;
}

// Genomes that differ in nothing but their ids.
std::vector<Genome> genomes(std::initializer_list<std::uint64_t> ids) {
  const auto population = Population::create(testing::lively(10), 3, 2, 1);
  std::vector<Genome> result;
  for (const std::uint64_t id : ids) {
    result.push_back(population->ask()[0]);
    result.back().set_id(id);
  }
  return result;
}

void add(Archive& archive, std::initializer_list<std::uint64_t> ids, std::vector<double> fitness,
         std::vector<Behaviour> behaviour, std::uint32_t generation = 0) {
  archive.add(generation, genomes(ids), fitness, behaviour);
}

std::uint64_t holder(const Archive& archive, std::uint32_t cell) {
  const auto found = archive.elites().find(cell);
  return found == archive.elites().end() ? 0 : found->second.genome.id();
}

TEST(Archive, CellsPartTheSquareEvenlyAndTheLastHoldsItsUpperEdge) {
  const Archive archive(grid(4, 3));
  EXPECT_EQ(archive.cells(), 12U);
  EXPECT_EQ(archive.cell_of({0, 0}), 0U);
  EXPECT_EQ(archive.cell_of({0.2499, 0}), 0U);
  EXPECT_EQ(archive.cell_of({0.25, 0}), 1U);
  EXPECT_EQ(archive.cell_of({1, 0}), 3U);
  EXPECT_EQ(archive.cell_of({0, 1}), 8U);
  EXPECT_EQ(archive.cell_of({0.6, 0.5}), 6U);
}

TEST(Archive, ACellKeepsItsFittestAndOfEqualsTheFirst) {
  Archive archive(grid(2, 1));
  add(archive, {1, 2, 3, 4}, {0.3, 0.5, 0.5, 0.9}, {{0.1, 0}, {0.2, 0}, {0.3, 0}, {0.8, 0}});
  EXPECT_EQ(holder(archive, 0), 2U);
  EXPECT_EQ(holder(archive, 1), 4U);
  add(archive, {5, 6}, {0.5, 0.91}, {{0.1, 0}, {0.8, 0}}, 1);
  EXPECT_EQ(holder(archive, 0), 2U);
  EXPECT_EQ(holder(archive, 1), 6U);
  EXPECT_EQ(archive.elites().at(1).generation, 1U);
  EXPECT_EQ(archive.changed(), (std::set<std::uint32_t>{1}));
}

TEST(Archive, WhatIsNotFiniteNeverEnters) {
  Archive archive(grid(2, 2));
  add(archive, {1, 2, 3}, {kNan, 0.5, std::numeric_limits<double>::infinity()},
      {{0.1, 0}, {kNan, 0}, {0.1, 0}});
  EXPECT_TRUE(archive.elites().empty());
}

TEST(Archive, AnEliteThatIsJudgedAgainKeepsTheMeanSoLuckWearsOff) {
  Archive archive(grid(2, 1));
  add(archive, {1}, {0.9}, {{0.25, 0}});
  add(archive, {1, 2}, {0.3, 0.7}, {{0.25, 0}, {0.25, 0}}, 1);
  // 1 has a mean of 0.6 by now: 2 is better.
  EXPECT_EQ(holder(archive, 0), 2U);
  add(archive, {2}, {0.8}, {{0.45, 0}}, 2);
  EXPECT_EQ(archive.elites().at(0).judged, 2U);
  EXPECT_DOUBLE_EQ(archive.elites().at(0).fitness(), 0.75);
  EXPECT_DOUBLE_EQ(archive.elites().at(0).behaviour().x, 0.35);
  EXPECT_EQ(archive.elites().at(0).generation, 1U);
}

TEST(Archive, AnEliteMovesWithItsMeanAndTheCellItLeavesIsEmpty) {
  Archive archive(grid(2, 1));
  add(archive, {1}, {0.5}, {{0.4, 0}});
  add(archive, {1}, {0.5}, {{0.8, 0}}, 1);  // mean 0.6
  EXPECT_EQ(holder(archive, 0), 0U);
  EXPECT_EQ(holder(archive, 1), 1U);
  EXPECT_EQ(archive.changed(), (std::set<std::uint32_t>{0, 1}));
}

TEST(Archive, TwoElitesMayChangePlaces) {
  Archive archive(grid(2, 1));
  add(archive, {1, 2}, {0.5, 0.6}, {{0.4, 0}, {0.6, 0}});
  add(archive, {1, 2}, {0.5, 0.6}, {{0.8, 0}, {0.2, 0}}, 1);  // means 0.6 and 0.4
  EXPECT_EQ(holder(archive, 0), 2U);
  EXPECT_EQ(holder(archive, 1), 1U);
}

TEST(Archive, HeadingsAreACircle) {
  proto::ArchiveConfig config = grid(4, 1);
  config.mutable_x()->set_of(proto::YAW);
  config.set_neighbours(1);
  Archive archive(config);
  // 0.05 and 0.97 (18 and -11 degrees beside 0.0) lie 0.08 apart.
  EXPECT_NEAR(archive.novelty(std::vector<Behaviour>{{0.05, 0}, {0.97, 0}})[0], 0.08, 1e-12);
  add(archive, {1}, {0.5}, {{0.05, 0}});
  add(archive, {1}, {0.5}, {{0.97, 0}}, 1);  // mean 0.01, not 0.51
  ASSERT_EQ(holder(archive, 0), 1U);
  EXPECT_NEAR(archive.elites().at(0).behaviour().x, 0.01, 1e-12);
}

TEST(Archive, NoveltyIsTheMeanDistanceToTheNearest) {
  proto::ArchiveConfig config = grid(4, 4);
  config.set_neighbours(2);
  config.set_remembered(1);
  config.set_memory(2);
  Archive archive(config);
  const std::vector<Behaviour> behaviour = {{0, 0}, {0.3, 0}, {0, 0.4}, {kNan, 0}};
  const std::vector<double> novelty = archive.novelty(behaviour);
  EXPECT_DOUBLE_EQ(novelty[0], (0.3 + 0.4) / 2);
  EXPECT_DOUBLE_EQ(novelty[1], (0.3 + 0.5) / 2);
  EXPECT_DOUBLE_EQ(novelty[2], (0.4 + 0.5) / 2);
  EXPECT_EQ(novelty[3], 0);
  archive.remember(behaviour, novelty);  // the most novel: 2
  ASSERT_EQ(archive.memory().size(), 1U);
  EXPECT_EQ(archive.memory()[0].y, 0.4);
  EXPECT_DOUBLE_EQ(archive.novelty(std::vector<Behaviour>{{0, 0.3}})[0], 0.1);
  archive.remember(std::vector<Behaviour>{{0.1, 0}}, std::vector<double>{0.5});
  archive.remember(std::vector<Behaviour>{{0.2, 0}}, std::vector<double>{0.5});
  ASSERT_EQ(archive.memory().size(), 2U);  // the oldest went
  EXPECT_EQ(archive.memory()[0].x, 0.1);
}

TEST(Archive, SelectionWeighsFitnessAndNoveltyOverTheGeneration) {
  const std::vector<double> fitness = {1, 3, 2, kNan}, novelty = {0.2, 0.1, 0.1, 0.3};
  const std::vector<double> scores = selection_scores(fitness, novelty, 0.25);
  EXPECT_DOUBLE_EQ(scores[0], 0.75 * 0 + 0.25 * 0.5);
  EXPECT_DOUBLE_EQ(scores[1], 0.75);
  EXPECT_DOUBLE_EQ(scores[2], 0.375);
  EXPECT_TRUE(std::isnan(scores[3]));
  for (const double score : selection_scores(std::vector<double>{2, 2}, std::vector<double>{0, 0}, 0.5))
    EXPECT_EQ(score, 0);
}

}  // namespace
}  // namespace evograsp::neat

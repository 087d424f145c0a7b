// Where grasps lie on the map, by values worked out by hand.
#include "score/grasp_measure.h"

#include <gtest/gtest.h>

#include <cmath>

namespace evograsp::score {
namespace {

void set(proto::Vec3* v, double x, double y, double z) {
  v->set_x(x);
  v->set_y(y);
  v->set_z(z);
}

// The tool point at s, the target at the origin.
proto::Measurement grasp(double dx, double dy, double dz, double sx = 0, double sy = 0, double sz = 0) {
  proto::Measurement m;
  set(m.mutable_approach(), dx, dy, dz);
  set(m.mutable_s(), sx, sy, sz);
  set(m.mutable_o(), 0, 0, 0);
  return m;
}

std::array<double, 2> place(proto::GraspMeasure x, proto::GraspMeasure y,
                            const std::vector<proto::Measurement>& trials) {
  proto::ArchiveConfig config;
  config.mutable_x()->set_of(x);
  config.mutable_y()->set_of(y);
  return GraspMap::create(config)->place(trials);
}

TEST(GraspMeasure, PitchTellsTopFromSide) {
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(place(proto::PITCH, proto::HEIGHT, {grasp(0, 0, -1)})[0], 1, 1e-12);
  EXPECT_NEAR(place(proto::PITCH, proto::HEIGHT, {grasp(1, 0, 0)})[0], 0, 1e-12);
  EXPECT_NEAR(place(proto::PITCH, proto::HEIGHT, {grasp(0, -half, -half)})[0], 0.5, 1e-12);
  EXPECT_NEAR(place(proto::PITCH, proto::HEIGHT, {grasp(0, 0, 1)})[0], 0, 1e-12)
      << "from below: the first bin";
  // The mean direction of one from above and one from the side.
  EXPECT_NEAR(place(proto::PITCH, proto::HEIGHT, {grasp(0, 0, -1), grasp(1, 0, 0)})[0], 0.5, 1e-12);
}

TEST(GraspMeasure, YawTurnsOnceAroundTheTable) {
  EXPECT_NEAR(place(proto::YAW, proto::PITCH, {grasp(1, 0, 0)})[0], 0.5, 1e-12);
  EXPECT_NEAR(place(proto::YAW, proto::PITCH, {grasp(0, 1, 0)})[0], 0.75, 1e-12);
  EXPECT_NEAR(place(proto::YAW, proto::PITCH, {grasp(0, -1, 0)})[0], 0.25, 1e-12);
}

TEST(GraspMeasure, HeightOffsetAndDepthAreMeansOfWhereTheToolPointEnded) {
  const std::vector<proto::Measurement> trials = {grasp(0, 0, -1, 0.03, 0.04, 0.02),
                                                  grasp(0, 0, -1, 0, 0, 0.06)};
  EXPECT_NEAR(place(proto::PITCH, proto::HEIGHT, trials)[1], 0.7, 1e-12);   // 4 cm of -10 to 10
  EXPECT_NEAR(place(proto::PITCH, proto::OFFSET, trials)[1], 0.25, 1e-12);  // 5 and 0 cm of 10
  EXPECT_NEAR(place(proto::PITCH, proto::DEPTH, trials)[1], 0.7, 1e-12);    // the target 4 cm ahead
}

TEST(GraspMeasure, RangesOfTheConfigHoldAndLimit) {
  proto::ArchiveConfig config;
  config.mutable_y()->set_of(proto::HEIGHT);
  config.mutable_y()->set_low(0);
  config.mutable_y()->set_high(0.05);
  const auto map = GraspMap::create(config);
  ASSERT_TRUE(map);
  const auto y = [&](double height) {
    const std::vector<proto::Measurement> trials = {grasp(0, 0, -1, 0, 0, height)};
    return map->place(trials)[1];
  };
  EXPECT_NEAR(y(0.01), 0.2, 1e-12);
  EXPECT_EQ(y(0.2), 1);
  EXPECT_EQ(y(-0.2), 0);
  config.mutable_y()->set_high(0);
  EXPECT_FALSE(GraspMap::create(config));
}

TEST(GraspMeasure, TrialsWithoutAPoseSayNothing) {
  proto::Measurement none;
  none.set_outcome(proto::NOT_A_NUMBER);
  EXPECT_TRUE(std::isnan(place(proto::PITCH, proto::HEIGHT, {none, none})[0]));
  EXPECT_TRUE(std::isnan(place(proto::PITCH, proto::HEIGHT, {})[1]));
  EXPECT_NEAR(place(proto::PITCH, proto::HEIGHT, {none, grasp(0, 0, -1, 0, 0, 0.05)})[1], 0.75, 1e-12);
  EXPECT_TRUE(std::isnan(place(proto::PITCH, proto::HEIGHT, {grasp(1, 0, 0), grasp(-1, 0, 0)})[0]))
      << "opposite directions have no mean";
}

}  // namespace
}  // namespace evograsp::score

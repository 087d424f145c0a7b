#include "sim/depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene_objects.h"
#include "sim/decode.h"
#include "sim/kinect_noise.h"
#include "sim/scene.h"

namespace evograsp::sim {
namespace {

using ::testing::HasSubstr;

Placements standing(const std::vector<proto::ObjectBundle>& objects, const std::vector<Vec3>& at) {
  Placements p;
  p.seed = 42;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    p.pose.push_back({Mat3::Identity(), at[i]});
    p.resting.push_back(0);
    p.present.push_back(1);
  }
  return p;
}

TEST(DepthCamera, ABallOnTheAxisHasTheDepthsOfTheFormula) {
  proto::Experiment experiment = testing::experiment();
  *experiment.mutable_camera()->mutable_eye() = to_proto(Vec3(0, 0, 1));
  const double r = 0.05;
  const std::vector<proto::ObjectBundle> objects = {testing::ball(r)};
  const DepthCamera camera = *DepthCamera::create(experiment, objects);
  const Info info = *camera.look(standing(objects, {Vec3(0, 0, r)}), 0, 0, false);
  ASSERT_EQ(info.depth.size(), 300u);
  int on_ball = 0;
  for (int row = 0; row < 15; ++row)
    for (int column = 0; column < 20; ++column) {
      // tan of the angle from the axis; the ball's centre lies at depth D = 1 - r.
      const double a = (-0.5 + (column + 0.5) * 32 - 319.5) / 525,
                   b = (-0.5 + (row + 0.5) * 32 - 239.5) / 525;
      const double k = 1 + a * a + b * b, d = 1 - r;
      const double disc = d * d - k * (d * d - r * r);
      double z = disc >= 0 ? (d - std::sqrt(disc)) / k : 1.0;
      if (disc < 0 && (std::fabs(a) > 0.5 || std::fabs(b) > 0.5)) z = 1.5;  // past the table's edge
      on_ball += disc >= 0;
      EXPECT_NEAR(info.depth[static_cast<std::size_t>(row * 20 + column)], (z - 0.2) / 1.3, 1e-6)
          << row << ' ' << column;
    }
  EXPECT_GT(on_ball, 0);
}

TEST(DepthCamera, GridsOfAnySize) {
  const std::vector<proto::ObjectBundle> objects = {testing::box(0.03, 0.03, 0.03)};
  for (const auto& [columns, rows] : {std::pair{40u, 30u}, {80u, 60u}, {1u, 1u}, {640u, 480u}}) {
    proto::Experiment experiment = testing::experiment();
    experiment.mutable_camera()->set_columns(columns), experiment.mutable_camera()->set_rows(rows);
    const DepthCamera camera = *DepthCamera::create(experiment, objects);
    const Info info = *camera.look(standing(objects, {Vec3(0, 0, 0.03)}), 0, 0, true);
    EXPECT_EQ(info.depth.size(), columns * rows);
  }
}

TEST(DepthCamera, TheWindowMovesWithTheTarget) {
  const std::vector<proto::ObjectBundle> objects = {testing::ball(0.04)};
  const DepthCamera camera = *DepthCamera::create(testing::experiment(), objects);
  for (const double y : {-0.15, 0.0, 0.15}) {
    const Info info = *camera.look(standing(objects, {Vec3(0, y, 0.04)}), 0, 0, true);
    const Vec3 to_eye = (camera.camera().eye() - Vec3(0, y, 0.04)).normalized();
    EXPECT_LT((info.anchor - (Vec3(0, y, 0.04) + 0.04 * to_eye)).norm(), 1e-6) << "the front of the ball";
    EXPECT_NEAR(info.box_w, 2 * 0.04 / 0.75 * 525 / 640, 0.006);
  }
  const Info whole = *camera.look(standing(objects, {Vec3(0, 0.1, 0.04)}), 0, 0, false);
  EXPECT_EQ(whole.anchor, Vec3(0, 0, 0.125));
}

TEST(DepthCamera, ClicksAreVisiblePixelsOfTheTargetSpreadOverIt) {
  const std::vector<proto::ObjectBundle> objects = {testing::box(0.04, 0.04, 0.04), testing::ball(0.04)};
  const DepthCamera camera = *DepthCamera::create(testing::experiment(), objects);
  // The ball stands in front of the box and hides part of it.
  const Placements p = standing(objects, {Vec3(0, 0, 0.04), Vec3(0.1, 0.02, 0.04)});
  const PosedScene scene(camera.caster(), p.pose, p.present);
  double left = 0;
  for (int click = 0; click < 400; ++click) {
    const Info info = *camera.look(p, 0, click, true);
    const Pixel pixel{info.click_a * 640 - 0.5, info.click_b * 480 - 0.5};
    EXPECT_NEAR(pixel.u, std::round(pixel.u), 1e-9);
    EXPECT_EQ(scene.cast(camera.camera().ray(pixel), 0, 10).body, 0);
    EXPECT_NEAR((camera.camera().project(info.point)->u), pixel.u, 1e-6);
    EXPECT_LT((info.point - Vec3(0, 0, 0.04)).cwiseAbs().maxCoeff(), 0.0401);
    left += info.point.y() < -0.01;
  }
  EXPECT_GT(left, 40);
  EXPECT_LT(left, 360);
}

TEST(DepthCamera, TheClickDependsOnSeedTargetAndClickOnly) {
  const std::vector<proto::ObjectBundle> objects = {testing::box(0.04, 0.04, 0.04)};
  const DepthCamera camera = *DepthCamera::create(testing::experiment(), objects);
  Placements p = standing(objects, {Vec3(0, 0, 0.04)});
  const Info a = *camera.look(p, 0, 3, true), b = *camera.look(p, 0, 3, false),
             c = *camera.look(p, 0, 4, true);
  EXPECT_EQ(a.click_a, b.click_a);
  EXPECT_NE(std::pair(a.click_a, a.click_b), std::pair(c.click_a, c.click_b));
  p.seed = 43;
  EXPECT_NE(a.click_a, camera.look(p, 0, 3, true)->click_a);
}

TEST(DepthCamera, ASliverIsFoundByCountingAndAHiddenTargetIsAnError) {
  const std::vector<proto::ObjectBundle> objects = {testing::ball(0.02), testing::box(0.01, 0.2, 0.2)};
  const DepthCamera camera = *DepthCamera::create(testing::experiment(), objects);
  // A wall before the ball; its top lets a few rows of pixels of the ball through, then none.
  int found = 0, hidden = 0;
  for (int i = 0; i <= 40; ++i) {
    const Placements p = standing(objects, {Vec3(0, 0, 0.02), Vec3(0.12, 0, -0.08 + 0.002 * i)});
    const Result<Info> info = camera.look(p, 0, 0, true);
    found += info.has_value();
    hidden += !info;
    if (!info) {
      EXPECT_THAT(info.error().message, HasSubstr("no pixel of target 0"));
    }
  }
  EXPECT_GT(found, 2);
  EXPECT_GT(hidden, 2);
}

TEST(DepthCamera, WrongTargetsAreErrors) {
  const std::vector<proto::ObjectBundle> objects = {testing::ball(0.03)};
  const DepthCamera camera = *DepthCamera::create(testing::experiment(), objects);
  Placements p = standing(objects, {Vec3(0, 0, 0.03)});
  EXPECT_FALSE(camera.look(p, 1, 0, true));
  EXPECT_FALSE(camera.look(p, -1, 0, true));
  EXPECT_FALSE(camera.look(Placements(), 0, 0, true));
  p.present[0] = 0;
  EXPECT_THAT(camera.look(p, 0, 0, true).error().message, HasSubstr("not in this scene"));
}

TEST(DepthCamera, NoiseIsSeededAndOffByDefault) {
  const std::vector<proto::ObjectBundle> objects = {testing::ball(0.04)};
  proto::Experiment experiment = testing::experiment();
  const DepthCamera clean = *DepthCamera::create(experiment, objects);
  experiment.mutable_camera()->mutable_noise();
  const DepthCamera noisy = *DepthCamera::create(experiment, objects);
  Placements p = standing(objects, {Vec3(0, 0, 0.04)});
  const Info a = *noisy.look(p, 0, 0, true);
  EXPECT_EQ(a.depth, noisy.look(p, 0, 0, true)->depth);
  EXPECT_EQ(clean.look(p, 0, 0, true)->depth, clean.look(p, 0, 0, true)->depth);
  double difference = 0;
  for (std::size_t i = 0; i < 300; ++i)
    difference = std::max<double>(difference, std::fabs(a.depth[i] - clean.look(p, 0, 0, true)->depth[i]));
  EXPECT_GT(difference, 0.0005);
  p.seed = 7;
  EXPECT_NE(a.depth, noisy.look(p, 0, 0, true)->depth);
}

TEST(KinectNoise, GrowsWithDistanceAsTheModelSays) {
  proto::KinectNoise config;
  config.set_quantise(false);
  const Camera camera = *Camera::create(proto::CameraConfig());
  const Ray ray{Vec3::Zero(), Vec3(0, 0, 1)};
  for (const double z : {0.5, 1.0, 1.4}) {
    Random random(1, Purpose::kTestHarness);
    double sum = 0, squares = 0;
    constexpr int kDraws = 20000;
    for (int i = 0; i < kDraws; ++i) {
      const double error = noisy_depth(config, camera, ray, Vec3(0, 0, -1), z, random) - z;
      sum += error, squares += error * error;
    }
    const double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
    EXPECT_NEAR(sum / kDraws, 0, 5 * sigma / std::sqrt(kDraws));
    EXPECT_NEAR(std::sqrt(squares / kDraws), sigma, 0.03 * sigma);
  }
}

TEST(KinectNoise, GrazingSurfacesAreLostAndStepsAreDisparities) {
  proto::KinectNoise config;
  config.set_axial(0);
  const Camera camera = *Camera::create(proto::CameraConfig());
  const Ray ray{Vec3::Zero(), Vec3(0, 0, 1)};
  Random random(1, Purpose::kTestHarness);
  const auto tilted = [](double angle) { return Vec3(std::sin(angle), 0, -std::cos(angle)); };
  EXPECT_EQ(noisy_depth(config, camera, ray, tilted(1.41), 1, random), camera.far());
  const double seen = noisy_depth(config, camera, ray, tilted(1.39), 1, random);
  EXPECT_LT(seen, camera.far());
  const double steps = 8 * 0.075 * 525 / seen;
  EXPECT_NEAR(steps, std::round(steps), 1e-9);
  config.set_dropout(1);
  EXPECT_EQ(noisy_depth(config, camera, ray, tilted(0), 1, random), camera.far());
}

TEST(Decode, HomeLooksDownWithFingersAlongMinusX) {
  proto::HandBundle hand;
  *hand.mutable_approach_axis() = to_proto(Vec3(0, 1, 0));
  *hand.mutable_finger_axis() = to_proto(Vec3(0, 0, 1));
  const Mat3 home = home_rotation({}, hand);
  EXPECT_LT((home * Vec3(0, 1, 0) - Vec3(0, 0, -1)).norm(), 1e-12);
  EXPECT_LT((home * Vec3(0, 0, 1) - Vec3(-1, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(home.determinant(), 1, 1e-12);
}

TEST(Decode, PositionsFillTheWorkspaceAndRotationsTurnTheHome) {
  Info info;
  info.anchor = Vec3(0.1, 0.2, 0.3);
  const std::vector<float> outputs = {1, -1, 0.5f, 0, 0, 2, 0.5f};
  const Pose pose = decode_pose({}, Mat3::Identity(), outputs, info, true);
  EXPECT_LT((pose.position - Vec3(0.25, 0.05, 0.375)).norm(), 1e-12);
  EXPECT_LT((pose.rotation * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm(), 1e-12) << "a quarter turn about z";
  const Pose still = decode_pose({}, Mat3::Identity(), std::vector<float>{0, 0, 0, 0, 0, 0, 1}, info, false);
  EXPECT_EQ(still.rotation, Mat3::Identity()) << "a zero axis means no rotation";
  Mat3 quarter;  // about the vertical
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Pose turned = decode_pose({}, Mat3::Identity(), outputs, info, true, quarter);
  EXPECT_LT((turned.position - Vec3(0.25, 0.35, 0.375)).norm(), 1e-12) << "about the anchor";
  EXPECT_LT((turned.rotation * Vec3(1, 0, 0) - Vec3(-1, 0, 0)).norm(), 1e-12);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(
      is_finite(decode_pose({}, Mat3::Identity(), std::vector<float>{0, 0, 0, 0, 0, 0, nan}, info, true)));
}

}  // namespace
}  // namespace evograsp::sim

// Features of a view against hand-made depth images and what stands in the scene.
#include "sim/view_features.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/view_features.h"
#include "tests/sim/trials.h"

namespace evograsp::sim {
namespace {

// A camera above the table that looks straight down (image right = -y, image up = +x of the world).
proto::CameraConfig from_above() {
  proto::CameraConfig config;
  config.mutable_eye()->set_x(0);
  config.mutable_eye()->set_y(0);
  config.mutable_eye()->set_z(1);
  for (const auto feature : {proto::CENTROID, proto::SIZE, proto::AXIS, proto::POINT})
    config.add_feature(feature);
  return config;
}

// Flat boxes of one height on the table, drawn by hand into the samples.
struct Painted {
  proto::CameraConfig config = from_above();
  Camera camera = *Camera::create(config);
  std::vector<float> depth;
  SampledView view;

  template <class Inside>
  Painted(double height, Inside inside) {
    view.camera = &camera;
    view.centre = {camera.width() / 2.0 - 0.5, camera.height() / 2.0 - 0.5};
    view.width = 160;
    view.height = 120;
    for (std::uint32_t row = 0; row < config.rows(); ++row)
      for (std::uint32_t column = 0; column < config.columns(); ++column) {
        const Pixel pixel{view.centre.u + ((column + 0.5) / config.columns() - 0.5) * view.width,
                          view.centre.v + ((row + 0.5) / config.rows() - 0.5) * view.height};
        const Vec3 top = camera.ray(pixel).at(1 - height);
        depth.push_back(camera.normalise(inside(top) ? 1 - height : 1.0));
      }
    view.depth = depth;
    view.point = Vec3(0, 0, height);
    view.unit = Vec3::Constant(0.1);
  }
  std::vector<float> features() const { return view_features(config, view); }
};

TEST(ViewFeatures, CountIsWhatTheNetworkIsTold) {
  const Painted painted(0.05, [](const Vec3&) { return true; });
  EXPECT_EQ(painted.features().size() + kClickAndBoxInputs, other_inputs(painted.config));
  EXPECT_EQ(network_inputs(proto::CameraConfig()), 304U);
}

// Cells are 8 px or 14.48 mm wide at the top of the object, 20 x 15 of them: the square covers 6 columns and
// 5 rows. n points a apart have a variance of a^2 (n^2 - 1) / 12.
TEST(ViewFeatures, CentroidHeightAndSpreadOfASquare) {
  const Painted painted(0.05,
                        [](const Vec3& p) { return std::abs(p.x()) < 0.043 && std::abs(p.y()) < 0.043; });
  const std::vector<float> f = painted.features();
  EXPECT_NEAR(f[0], 0, 0.02);                        // centroid x, in 10 cm
  EXPECT_NEAR(f[1], 0, 0.02);                        // y
  EXPECT_NEAR(f[2], 0.5, 1e-4);                      // z: 5 cm
  EXPECT_NEAR(f[3], 0.5, 1e-4);                      // height, in 10 cm
  EXPECT_NEAR(f[4], 0.4945, 0.01);                   // 24.7 mm, in 5 cm
  EXPECT_NEAR(f[5], 0.4096, 0.01);                   // 20.5 mm
  EXPECT_NEAR(std::hypot(f[6], f[7]), 0.169, 0.02);  // (611 - 419) / (611 + 419 + 100) mm^2
}

TEST(ViewFeatures, TheAxisOfABarTurnsTwiceAsFastAsTheBar) {
  for (const double angle : {0.0, 0.5, 1.2, 2.0, 3.0}) {
    const double c = std::cos(angle), s = std::sin(angle);
    const Painted painted(0.05, [&](const Vec3& p) {
      return std::abs(c * p.x() + s * p.y()) < 0.055 && std::abs(c * p.y() - s * p.x()) < 0.015;
    });
    const std::vector<float> f = painted.features();
    EXPECT_GT(f[4], 1.5F * f[5]);
    const double error = std::remainder(std::atan2(f[7], f[6]) - 2 * angle, 2 * M_PI);
    EXPECT_NEAR(error, 0, 0.35) << "bar at " << angle;
  }
}

TEST(ViewFeatures, TheObjectsFrameLiesAcrossTheBarNearTheWorldsX) {
  for (const double angle : {0.3, 1.2, 2.0, 2.9}) {
    const double c = std::cos(angle), s = std::sin(angle);
    Painted painted(0.05, [&](const Vec3& p) {
      return std::abs(c * p.x() + s * p.y()) < 0.055 && std::abs(c * p.y() - s * p.x()) < 0.015;
    });
    const std::vector<float> in_world = painted.features();
    EXPECT_EQ(pose_frame(painted.config, in_world), Mat3::Identity()) << "off by default";

    painted.config.set_object_frame(true);
    painted.view.anchor = Vec3(0.02, -0.03, 0.05);
    const Mat3 frame = pose_frame(painted.config, painted.features());
    EXPECT_LT((frame * frame.transpose() - Mat3::Identity()).norm(), 1e-12);
    EXPECT_EQ(frame.col(2), Vec3::UnitZ());
    EXPECT_GE(frame(0, 0), 0) << "bar at " << angle;
    EXPECT_LT(std::abs(frame.col(0).dot(Vec3(c, s, 0))), 0.18) << "bar at " << angle;

    const std::vector<float> f = painted.features();
    const Vec3 centroid(f[0], f[1], f[2]);
    EXPECT_LT(
        (frame * centroid * 0.1 + painted.view.anchor - Vec3(in_world[0], in_world[1], in_world[2]) * 0.1)
            .norm(),
        1e-6);
  }
}

// From straight above: the ray through the window's centre is the vertical through the origin; the mean of
// what is seen of a square about (0.03, 0.02) is where it is.
TEST(ViewFeatures, TheObjectsAnchorIsAtHalfItsHeight) {
  const Painted painted(
      0.06, [](const Vec3& p) { return std::abs(p.x() - 0.03) < 0.04 && std::abs(p.y() - 0.02) < 0.04; });
  const Vec3 boxed = object_anchor(painted.config, painted.view, true);
  EXPECT_NEAR(boxed.x(), 0, 0.002);
  EXPECT_NEAR(boxed.y(), 0, 0.002);
  EXPECT_NEAR(boxed.z(), 0.03, 1e-4);
  const Vec3 seen = object_anchor(painted.config, painted.view, false);
  EXPECT_NEAR(seen.x(), 0.03, 0.006);
  EXPECT_NEAR(seen.y(), 0.02, 0.006);
  EXPECT_NEAR(seen.z(), 0.03, 1e-4);
}

TEST(ViewFeatures, OnlyTheTableSeenMeansTheClickedPoint) {
  Painted painted(0.05, [](const Vec3&) { return false; });
  painted.view.point = Vec3(0.02, -0.01, 0.03);
  const std::vector<float> f = painted.features();
  for (int i = 0; i < 3; ++i) {
    EXPECT_FLOAT_EQ(f[static_cast<std::size_t>(i)], f[static_cast<std::size_t>(8 + i)]);
    EXPECT_NEAR(f[static_cast<std::size_t>(i)], painted.view.point[i] * 10, 1e-6);
  }
}

TEST(ViewFeatures, OtherObjectsAreLeftOut) {
  const auto left = [](const Vec3& p) { return (p - Vec3(0, 0.1, 0.05)).norm() < 0.02; };
  const auto both = [&](const Vec3& p) { return left(p) || (p - Vec3(0, -0.1, 0.05)).norm() < 0.02; };
  Painted one(0.05, left), two(0.05, both);
  one.view.point = two.view.point = Vec3(0, 0.1, 0.05);
  EXPECT_EQ(one.features(), two.features());
}

// The simulator's own view: without the window a coarse image must still tell where the object is.
TEST(ViewFeatures, TheCentroidFollowsTheObjectWithAndWithoutTheBox) {
  proto::Config config;
  config.mutable_scene()->add_object("sphere");
  config.mutable_camera()->add_feature(proto::CENTROID);
  const auto what = assets::resolve_experiment(config, EVOGRASP_SOURCE_DIR);
  ASSERT_TRUE(what) << what.error().message;
  const auto sim = Simulator::create(what->experiment, what->objects, what->hand);
  ASSERT_TRUE(sim) << sim.error().message;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto placements = (*sim)->shuffle(seed);
    ASSERT_TRUE(placements);
    const Vec3 centre = placements->pose[0].position;
    for (const bool box : {true, false}) {
      const auto info = (*sim)->get_info(*placements, 0, 0, box);
      ASSERT_TRUE(info);
      EXPECT_EQ(static_cast<int>(info->input_count()), (*sim)->inputs());
      const Vec3 unit = workspace_unit(what->experiment.grasp(), box);
      const Vec3 seen =
          info->anchor + Vec3(info->features[0], info->features[1], info->features[2]).cwiseProduct(unit);
      EXPECT_LT((seen - centre).norm(), box ? 0.04 : 0.055) << "seed " << seed << (box ? " box" : "");
    }
  }
}

}  // namespace
}  // namespace evograsp::sim

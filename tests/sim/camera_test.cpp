#include "sim/camera.h"

#include <gtest/gtest.h>

#include "common/random.h"
#include "scene_objects.h"
#include "sim/image_bounds.h"

namespace evograsp::sim {
namespace {

proto::CameraConfig config_with_eye(double x, double y, double z) {
  proto::CameraConfig config;
  *config.mutable_eye() = to_proto(Vec3(x, y, z));
  return config;
}

TEST(Camera, WorldOriginLandsOnThePrincipalPoint) {
  proto::CameraConfig config = config_with_eye(0.3, -0.4, 0.7);
  config.set_cx(200), config.set_cy(111);
  const Camera camera = *Camera::create(config);
  const std::optional<Pixel> pixel = camera.project(Vec3::Zero());
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->u, 200, 1e-9);
  EXPECT_NEAR(pixel->v, 111, 1e-9);
  EXPECT_NEAR(camera.depth(Vec3::Zero()), std::sqrt(0.09 + 0.16 + 0.49), 1e-12);
}

TEST(Camera, WorldUpIsImageUpAndTheFrameIsRightHanded) {
  for (const Vec3& eye : {Vec3(0.55, 0, 0.55), Vec3(0, 0.8, 0.2), Vec3(-0.3, 0.3, 0.9)}) {
    const Camera camera = *Camera::create(config_with_eye(eye.x(), eye.y(), eye.z()));
    EXPECT_LT(camera.project(Vec3(0, 0, 0.1))->v, camera.project(Vec3::Zero())->v);
    EXPECT_NEAR(camera.project(Vec3(0, 0, 0.1))->u, camera.project(Vec3::Zero())->u, 1e-9);
    EXPECT_NEAR(camera.pose().rotation.determinant(), 1, 1e-12);
  }
}

TEST(Camera, LooksStraightDownToo) {
  const Result<Camera> camera = Camera::create(config_with_eye(0, 0, 0.8));
  ASSERT_TRUE(camera);
  EXPECT_LT(camera->project(Vec3(0.1, 0, 0))->v, camera->cy());  // up in the image is +x
  EXPECT_NEAR(camera->pose().rotation.determinant(), 1, 1e-12);
}

TEST(Camera, RaysPassThroughWhatTheyProject) {
  const Camera camera = *Camera::create(proto::CameraConfig());
  Random random(7, Purpose::kTestHarness);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = testing::random_vector(random, 0.3);
    const Ray ray = camera.ray(*camera.project(p));
    EXPECT_LT((ray.at(camera.depth(p)) - p).norm(), 1e-12);
  }
}

TEST(Camera, PointsBehindTheCameraHaveNoPixel) {
  const Camera camera = *Camera::create(proto::CameraConfig());
  EXPECT_FALSE(camera.project(Vec3(1.2, 0, 1.2)));
}

TEST(Camera, DepthMapsLinearlyAndClamps) {
  proto::CameraConfig config;
  config.set_near(0.5), config.set_far(1.5);
  const Camera camera = *Camera::create(config);
  EXPECT_FLOAT_EQ(camera.normalise(0.75), 0.25f);
  EXPECT_FLOAT_EQ(camera.normalise(0.1), 0);
  EXPECT_FLOAT_EQ(camera.normalise(9), 1);
}

TEST(Camera, RefusesWhatCannotBeACamera) {
  proto::CameraConfig config;
  config.set_near(2), config.set_far(1);
  EXPECT_FALSE(Camera::create(config));
  EXPECT_FALSE(Camera::create(config_with_eye(0, 0, 0)));
  EXPECT_FALSE(Camera::create(config_with_eye(std::nan(""), 0, 1)));
  config = proto::CameraConfig();
  config.set_fx(std::nan(""));
  EXPECT_FALSE(Camera::create(config));
  config = proto::CameraConfig();
  config.set_image_width(1);
  EXPECT_FALSE(Camera::create(config));
}

// The reference: the box of many surface points. The exact box holds them all and is hardly wider.
TEST(ImageBounds, HoldsTheProjectionAndIsTight) {
  const Camera camera = *Camera::create(proto::CameraConfig());
  Random random(3, Purpose::kTestHarness);
  for (const proto::ObjectBundle& object :
       {testing::box(0.03, 0.05, 0.02), testing::ball(0.04), testing::cylinder(0.03, 0.06),
        testing::capsule(0.02, 0.04), testing::hull_box(0.03, 0.05, 0.02)}) {
    const Solid solid = *Solid::create(object.part(0));
    const ImageBounds bounds({solid});
    for (int trial = 0; trial < 20; ++trial) {
      Pose pose;
      const Vec3 axis = testing::random_vector(random, 1);
      pose.rotation = axis_angle(axis, random.uniform(-3, 3));
      pose.position = testing::random_vector(random, 0.15);
      const std::optional<ImageBox> box = bounds.project(camera, pose);
      ASSERT_TRUE(box);
      ImageBox seen{1e9, 1e9, -1e9, -1e9};
      for (int i = 0; i < 4000; ++i) {
        const Pixel p = *camera.project(pose * solid.support(testing::random_vector(random, 1)));
        seen.left = std::min(seen.left, p.u), seen.right = std::max(seen.right, p.u);
        seen.top = std::min(seen.top, p.v), seen.bottom = std::max(seen.bottom, p.v);
      }
      EXPECT_LE(box->left, seen.left + 1e-6) << object.name();
      EXPECT_GE(box->right, seen.right - 1e-6) << object.name();
      EXPECT_LE(box->top, seen.top + 1e-6) << object.name();
      EXPECT_GE(box->bottom, seen.bottom - 1e-6) << object.name();
      EXPECT_NEAR(box->width(), seen.width(), 1.0) << object.name();
      EXPECT_NEAR(box->height(), seen.height(), 1.0) << object.name();
    }
  }
}

}  // namespace
}  // namespace evograsp::sim

#include "sim/depth_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scene_objects.h"
#include "sim/depth.h"

namespace evograsp::sim {
namespace {

using ::testing::HasSubstr;

// What the simulated camera would record of a scene, in tenths of a millimetre.
GreyImage record(const DepthCamera& camera, const Placements& p) {
  const PosedScene scene(camera.caster(), p.pose, p.present);
  GreyImage image{camera.camera().width(), camera.camera().height(), {}};
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const Hit hit = scene.cast(camera.camera().ray({double(u), double(v)}), 0, 6);
      image.value.push_back(hit.body == kNothing ? 0
                                                 : static_cast<std::uint16_t>(std::lround(hit.t * 10000)));
    }
  return image;
}

Placements at(const Vec3& position) {
  Placements p;
  p.seed = 1;
  p.pose = {{Mat3::Identity(), position}};
  p.resting = {0};
  p.present = {1};
  return p;
}

ImageCamera tenths_of_millimetres() {
  ImageCamera camera;
  camera.units_per_metre = 10000;
  return camera;
}

TEST(RegisteredKinect, EquationsOfTheThesis) {
  // By hand: (100 - 320) * (900 - 100) * 0.0021 * 640/480 = -492.8 mm; (400 - 240) * 800 * 0.0021 = 268.8 mm.
  const Vec3 p = registered_kinect_point(100, 400, 900, 640, 480);
  EXPECT_NEAR(p.x(), -0.4928, 1e-12);
  EXPECT_NEAR(p.y(), 0.2688, 1e-12);
  EXPECT_NEAR(p.z(), 0.9, 1e-12);
}

TEST(RegisteredKinect, PixelsAndPointsAreInverse) {
  ImageCamera camera;
  camera.registered_kinect = true;
  const DepthImage image =
      *DepthImage::create({640, 480, std::vector<std::uint16_t>(640 * 480, 800)}, camera);
  for (const Pixel& pixel : {Pixel{0, 0}, Pixel{320, 240}, Pixel{600, 33}}) {
    const Vec3 p = image.point(pixel, 0.8);
    const Pixel back = image.pixel_of(p.x() / p.z(), p.y() / p.z(), 0.8);
    EXPECT_NEAR(back.u, pixel.u, 1e-9);
    EXPECT_NEAR(back.v, pixel.v, 1e-9);
  }
}

TEST(DepthImage, HolesTakeTheFarthestOfTheNearestRing) {
  GreyImage grey{9, 9, std::vector<std::uint16_t>(81, 0)};
  grey.value[4 * 9 + 2] = 900, grey.value[4 * 9 + 6] = 1200, grey.value[0] = 5000;
  const DepthImage image = *DepthImage::create(grey, {});
  EXPECT_FALSE(image.reading(4, 4));
  EXPECT_NEAR(*image.filled(4, 4), 1.2, 1e-6);
  EXPECT_NEAR(*image.filled(4, 4, true), 0.9, 1e-6);
  EXPECT_NEAR(*image.filled(2, 4), 0.9, 1e-6) << "a reading is left alone";
  EXPECT_FALSE(image.filled(-1, 4));
  const DepthImage empty = *DepthImage::create({60, 60, std::vector<std::uint16_t>(3600, 0)}, {});
  EXPECT_FALSE(empty.filled(30, 30));
}

TEST(DepthImage, RefusesCamerasThatAreNone) {
  const GreyImage grey{2, 2, {1, 1, 1, 1}};
  ImageCamera camera;
  camera.units_per_metre = 0;
  EXPECT_FALSE(DepthImage::create(grey, camera));
  camera = ImageCamera();
  camera.fx = std::nan("");
  EXPECT_FALSE(DepthImage::create(grey, camera));
  EXPECT_FALSE(DepthImage::create({}, ImageCamera()));
}

// The proof that recordings go through the same normalisation: a recording of the simulated camera itself
// gives what cmd_get_info gives.
TEST(Recording, OfTheTrainingCameraEqualsTheSimulatedInput) {
  proto::Experiment experiment = testing::experiment();
  experiment.mutable_scene()->set_table_half_size(8);  // no edge, beyond which a recording has holes
  const std::vector<proto::ObjectBundle> objects = {testing::box(0.04, 0.04, 0.04)};
  const DepthCamera camera = *DepthCamera::create(experiment, objects);
  const Placements p = at(Vec3(0.05, -0.06, 0.04));
  const DepthImage image = *DepthImage::create(record(camera, p), tenths_of_millimetres());
  for (const bool box : {true, false}) {
    const Info live = *camera.look(p, 0, 0, box);
    const int u = static_cast<int>(live.click_a * 640 - 0.25),
              v = static_cast<int>(live.click_b * 480 - 0.25);
    RecordedOptions options;
    options.bounding_box = box;
    options.at_training_distance = false;
    const Result<Info> recorded =
        look_at_recording(image, experiment.camera(), camera.camera(), proto::GraspConfig(), u, v, options);
    ASSERT_TRUE(recorded) << recorded.error().message;
    int off = 0;
    for (std::size_t i = 0; i < 300; ++i) off += std::fabs(recorded->depth[i] - live.depth[i]) > 0.008;
    EXPECT_LE(off, box ? 30 : 8) << "only samples at silhouettes may differ";
    EXPECT_NEAR(recorded->click_a, live.click_a, 1e-3);
    EXPECT_NEAR(recorded->click_b, live.click_b, 1e-3);
    EXPECT_LT((recorded->point - live.point).norm(), 2e-3);
    EXPECT_NEAR(recorded->box_w, live.box_w, 0.02);
    EXPECT_NEAR(recorded->box_h, live.box_h, 0.04);
    EXPECT_LT((recorded->anchor - live.anchor).norm(), 0.01);
  }
}

TEST(Recording, AnotherDistanceAndFocalLengthLookAlike) {
  proto::Experiment far = testing::experiment();
  *far.mutable_camera()->mutable_eye() = to_proto(Vec3(0.8, 0, 0.8));
  far.mutable_camera()->set_fx(900), far.mutable_camera()->set_fy(900);
  const std::vector<proto::ObjectBundle> objects = {testing::ball(0.04)};
  const DepthCamera recorder = *DepthCamera::create(far, objects);
  const proto::Experiment training = testing::experiment();
  const DepthCamera trainer = *DepthCamera::create(training, objects);
  const Placements p = at(Vec3(0, 0, 0.04));
  ImageCamera camera = tenths_of_millimetres();
  camera.fx = camera.fy = 900;
  const DepthImage image = *DepthImage::create(record(recorder, p), camera);
  const Pixel centre = *recorder.camera().project(Vec3(0, 0, 0.04));
  const Info seen = *look_at_recording(image, training.camera(), trainer.camera(), proto::GraspConfig(),
                                       static_cast<int>(centre.u), static_cast<int>(centre.v), {});
  const Info live = *trainer.look(p, 0, 0, true);
  double mean = 0;
  for (std::size_t i = 0; i < 300; ++i) mean += std::fabs(seen.depth[i] - live.depth[i]) / 300;
  EXPECT_LT(mean, 0.03);
  EXPECT_NEAR(seen.box_w, live.box_w, 0.02);
  // The anchor, taken back to the recording camera, is the front of the ball.
  const Vec3 front = recorder.camera().pose() * (trainer.camera().pose().inverse() * seen.anchor);
  EXPECT_NEAR((front - Vec3(0, 0, 0.04)).norm(), 0.04, 0.002);
}

TEST(Recording, ClicksThatSeeNothingAreErrors) {
  const proto::Experiment experiment = testing::experiment();
  const Camera camera = *Camera::create(experiment.camera());
  const DepthImage image = *DepthImage::create({640, 480, std::vector<std::uint16_t>(640 * 480, 0)}, {});
  const auto error = [&](int u, int v) {
    return look_at_recording(image, experiment.camera(), camera, proto::GraspConfig(), u, v, {})
        .error()
        .message;
  };
  EXPECT_THAT(error(640, 3), HasSubstr("outside"));
  EXPECT_THAT(error(-1, 3), HasSubstr("outside"));
  EXPECT_THAT(error(100, 100), HasSubstr("no depth reading"));
}

TEST(Segment, IsTheClickedObjectAlone) {
  const std::vector<proto::ObjectBundle> objects = {testing::box(0.03, 0.03, 0.03), testing::ball(0.04)};
  const DepthCamera camera = *DepthCamera::create(testing::experiment(), objects);
  Placements p = at(Vec3(0, -0.1, 0.03));
  p.pose.push_back({Mat3::Identity(), Vec3(0, 0.1, 0.04)});
  p.resting.push_back(0), p.present.push_back(1);
  const DepthImage image = *DepthImage::create(record(camera, p), tenths_of_millimetres());
  const Pixel inside = *camera.camera().project(Vec3(0, 0.1, 0.05));
  const std::optional<Segment> ball =
      segment_clicked(image, static_cast<int>(inside.u), static_cast<int>(inside.v));
  ASSERT_TRUE(ball);
  const ImageBox box = *ImageBounds({*Solid::create(objects[1].part(0))}).project(camera.camera(), p.pose[1]);
  EXPECT_NEAR(ball->left, box.left, 4);
  EXPECT_NEAR(ball->right, box.right, 4);
  EXPECT_NEAR(ball->top, box.top, 4);
  EXPECT_NEAR(ball->bottom, box.bottom, 14) << "the foot of the ball touches the table";
  const Pixel table = *camera.camera().project(Vec3(0.1, 0, 0));
  EXPECT_FALSE(segment_clicked(image, static_cast<int>(table.u), static_cast<int>(table.v)));
}

}  // namespace
}  // namespace evograsp::sim

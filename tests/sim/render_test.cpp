#include "sim/render.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scene_objects.h"
#include "sim/depth_image.h"
#include "sim/render_overlay.h"
#include "sim/render_scene.h"

namespace evograsp::sim {
namespace {

using ::testing::HasSubstr;

struct Colour {
  int r, g, b;
};
Colour at(const ColourImage& image, int u, int v) {
  const std::uint8_t* rgb =
      &image.rgb[3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                      static_cast<std::size_t>(u))];
  return {rgb[0], rgb[1], rgb[2]};
}
int brightness(const Colour& c) {
  return c.r + c.g + c.b;
}

Placements one_at(const Vec3& position) {
  Placements p;
  p.pose = {{Mat3::Identity(), position}};
  p.resting = {0};
  p.present = {1};
  return p;
}

RenderScene red_ball() {
  RenderScene scene;
  const std::vector<proto::ObjectBundle> objects = {testing::ball(0.04)};
  EXPECT_TRUE(add_objects(scene, objects, one_at(Vec3(0, 0, 0.04))));
  return scene;
}

Camera above() {
  return Camera::look_at(Vec3(0, 0, 0.8), Vec3::Zero(), 120, 90, 0.4);
}

TEST(Render, ShowsTheBallTheTableAndAShadow) {
  const ColourImage image = render(red_ball(), above());
  const Colour ball = at(image, 60, 45), table = at(image, 5, 80);
  EXPECT_GT(ball.r, ball.b + 40) << "the first object of the palette is red";
  EXPECT_LT(std::abs(table.r - table.b), 40) << "the table is grey";
  // The light stands over -y: the shadow falls towards +y, which is left in this view.
  int darkest = 999, where = 0;
  for (int u = 0; u < 120; ++u)
    for (int v = 0; v < 90; ++v)
      if (const Colour c = at(image, u, v); std::abs(c.r - c.b) < 30 && brightness(c) < darkest)
        darkest = brightness(c), where = u;
  EXPECT_LT(darkest, brightness(table) * 3 / 4);
  EXPECT_LT(where, 60);
}

TEST(Render, ThePictureDoesNotDependOnThreads) {
  RenderOptions one, three;
  one.threads = 1, three.threads = 3;
  EXPECT_EQ(render(red_ball(), above(), one).rgb, render(red_ball(), above(), three).rgb);
}

TEST(Render, ContactsShineThroughWhatHidesThem) {
  RenderScene scene = red_ball();
  const std::uint8_t before = static_cast<std::uint8_t>(at(render(scene, above()), 60, 45).g);
  Contact contact{};
  contact.point = Vec3(0, 0, 0.02);  // within the ball
  contact.normal = Vec3(0, 0, 1);
  contact.mu = 0.8;
  ASSERT_TRUE(add_contacts(scene, std::vector<Contact>{contact}));
  EXPECT_NE(at(render(scene, above()), 60, 45).g, before);
}

TEST(Render, DepthIsReadableAsARecording) {
  const proto::CameraConfig config;
  const Camera camera = *Camera::create(config);
  auto bodies = std::make_shared<std::vector<RayBody>>();
  bodies->push_back(*RayBody::create(testing::ball(0.04)));
  const RayCaster caster(bodies, 0.5);
  const std::vector<Pose> poses = {{Mat3::Identity(), Vec3(0, 0, 0.04)}};
  const GreyImage grey = render_depth(PosedScene(caster, poses, {}), camera, 10000);
  ImageCamera same;
  same.units_per_metre = 10000;
  const DepthImage image = *DepthImage::create(*decode_grey16(*encode_png(grey), "round trip"), same);
  const Pixel centre = *camera.project(Vec3(0, 0, 0.04));
  const int u = static_cast<int>(std::lround(centre.u)), v = static_cast<int>(std::lround(centre.v));
  EXPECT_NEAR(*image.reading(u, v), camera.depth(Vec3(0, 0, 0.04)) - 0.04, 2e-4);
  EXPECT_FALSE(image.reading(0, 0)) << "past the table there is no return";
}

TEST(LinkPoses, FollowTheJoints) {
  proto::HandBundle hand;
  for (int i = 0; i < 3; ++i) hand.add_link();
  proto::HandBundle::Joint* turn = hand.add_joint();
  *turn->mutable_origin()->mutable_position() = to_proto(Vec3(0.1, 0, 0));
  *turn->mutable_axis() = to_proto(Vec3(0, 0, 1));
  proto::HandBundle::Joint* slide = hand.add_joint();
  slide->set_parent_link(1), slide->set_prismatic(true);
  *slide->mutable_axis() = to_proto(Vec3(1, 0, 0));
  const Pose palm{Mat3::Identity(), Vec3(0, 0, 1)};
  const std::vector<Pose> poses = link_poses(hand, palm, std::vector<double>{1.5707963267948966, 0.05});
  // The first joint turns the finger to +y at x = 0.1; the second slides along it.
  EXPECT_LT((poses[2].position - Vec3(0.1, 0.05, 1)).norm(), 1e-12);
  hand.add_preset(0), hand.add_preset(0.02);
  EXPECT_LT((link_poses(hand, palm, {})[2].position - Vec3(0.12, 0, 1)).norm(), 1e-12)
      << "no joints: the preset";
}

TEST(Views, NamesAndCoordinatesLookAtTheSubject) {
  const Camera depth = *Camera::create(proto::CameraConfig());
  const Subject subject{Vec3(0.1, 0, 0.05), 0.1};
  for (const char* view : {"corner", "front", "side", "top", "0.5 0.5 0.5"}) {
    const Result<Camera> camera = choose_view(view, depth, subject, 400, 300);
    ASSERT_TRUE(camera) << view;
    const Pixel at = *camera->project(subject.centre);
    EXPECT_NEAR(at.u, 199.5, 1e-6) << view;
    EXPECT_NEAR(at.v, 149.5, 1e-6) << view;
  }
  const Camera same = *choose_view("camera", depth, subject, 1280, 960);
  const Pixel p = *depth.project(Vec3(0.1, 0.1, 0)), q = *same.project(Vec3(0.1, 0.1, 0));
  EXPECT_NEAR((p.u + 0.5) * 2 - 0.5, q.u, 1e-9);
  EXPECT_NEAR((p.v + 0.5) * 2 - 0.5, q.v, 1e-9);
  for (const char* bad : {"", "behind", "1 2", "1 2 3 4", "nan 0 0", "0.1 0 0.05"})
    EXPECT_THAT(choose_view(bad, depth, subject, 400, 300).error().message, HasSubstr("unknown view")) << bad;
}

TEST(Overlay, DrawsWhereItIsTold) {
  ColourImage image(200, 150);
  Overlay overlay(image);
  overlay.rectangle({20, 30, 120, 90});
  overlay.cross({160, 40});
  overlay.caption("epsilon 0.3");
  const ColourImage out = overlay.finish();
  EXPECT_GT(at(out, 70, 30).r, 150);
  EXPECT_EQ(brightness(at(out, 70, 60)), 0);
  EXPECT_GT(at(out, 166, 40).r, 150);
  EXPECT_GT(brightness(at(out, 20, 132)), 400) << "the caption's strip";
}

TEST(DepthColours, NearIsBrightFarIsDarkNothingIsGrey) {
  const std::vector<float> depth = {0.2f, 0.5f, 0.8f, 1.f};
  const ColourImage image = colour_depth(depth, 2, 2, 8);
  EXPECT_EQ(image.width, 16);
  EXPECT_GT(brightness(at(image, 3, 3)), brightness(at(image, 12, 3)));
  EXPECT_GT(brightness(at(image, 12, 3)), brightness(at(image, 3, 12)));
  EXPECT_EQ(at(image, 12, 12).r, at(image, 12, 12).b);
  const ColourImage both = beside(image, ColourImage(10, 30), 4);
  EXPECT_EQ(both.width, 30);
  EXPECT_EQ(both.height, 30);
  EXPECT_EQ(brightness(at(both, 18, 5)), 765) << "white between";
}

}  // namespace
}  // namespace evograsp::sim

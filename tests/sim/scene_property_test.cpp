#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/scene_subset.h"
#include "scene_objects.h"
#include "sim/scene.h"

namespace evograsp::sim {
namespace {

using ::testing::HasSubstr;

std::vector<proto::ObjectBundle> four_objects() {
  proto::ObjectBundle cuboid = testing::box(0.02, 0.03, 0.05);
  proto::RestingPose* lying = cuboid.add_resting();
  *lying->mutable_orientation() = to_proto(rotation_about(Vec3(1, 0, 0), 1.5707963267948966));
  lying->set_height(0.03);
  cuboid.set_footprint_radius(0.06);
  return {cuboid, testing::ball(0.04), testing::cylinder(0.03, 0.06), testing::hull_box(0.03, 0.03, 0.03)};
}

Scene make(const proto::SceneConfig& config, const std::vector<proto::ObjectBundle>& objects) {
  return *Scene::create(config, *Camera::create(proto::CameraConfig()), objects);
}

TEST(Shuffle, NoOverlapsInsideTheAreaAndTheView) {
  const std::vector<proto::ObjectBundle> objects = four_objects();
  const proto::SceneConfig config;
  const Camera camera = *Camera::create(proto::CameraConfig());
  const Scene scene = make(config, objects);
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const Result<Placements> p = scene.shuffle(seed);
    ASSERT_TRUE(p) << p.error().message;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const Pose& pose = p->pose[i];
      EXPECT_LE(std::fabs(pose.position.x()), config.placement_half_x());
      EXPECT_LE(std::fabs(pose.position.y()), config.placement_half_y());
      EXPECT_EQ(pose.position.z(), objects[i].resting(p->resting[i]).height());
      const Solid solid = *Solid::create(objects[i].part(0));
      const Vec3 down = pose.rotation.transpose() * Vec3(0, 0, -1);
      EXPECT_NEAR((pose * solid.support(down)).z(), 0, 1e-9) << "rests on the table";
      EXPECT_TRUE(ImageBounds({solid}).project(camera, pose)->inside(camera));
      for (std::size_t j = 0; j < i; ++j) {
        const double apart = (pose.position - p->pose[j].position).head<2>().norm();
        EXPECT_GE(apart, objects[i].footprint_radius() + objects[j].footprint_radius() + config.clearance());
      }
    }
  }
}

TEST(Shuffle, DependsOnTheSeedAlone) {
  const Scene a = make({}, four_objects()), b = make({}, four_objects());
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Placements once = *a.shuffle(seed);
    *a.shuffle(seed + 1000);
    const Placements again = *b.shuffle(seed);
    for (std::size_t i = 0; i < once.pose.size(); ++i) {
      EXPECT_EQ(once.pose[i].position, again.pose[i].position);
      EXPECT_EQ(once.pose[i].rotation, again.pose[i].rotation);
    }
    EXPECT_NE(once.pose[0].position, a.shuffle(seed + 1)->pose[0].position);
  }
}

TEST(Shuffle, OnePositionIsUniformAndEveryRestingFaceComes) {
  const Scene scene = make({}, {four_objects()[0]});
  int quadrant[4] = {}, face[2] = {};
  double sum = 0;
  constexpr int kTrials = 4000;
  for (int seed = 0; seed < kTrials; ++seed) {
    const Placements p = *scene.shuffle(static_cast<std::uint64_t>(seed));
    const Vec3& at = p.pose[0].position;
    ++quadrant[(at.x() > 0) * 2 + (at.y() > 0)];
    ++face[p.resting[0]];
    sum += at.x() * at.x();
  }
  for (const int n : quadrant) EXPECT_NEAR(n, kTrials / 4, 130);  // 4.7 sigma
  for (const int n : face) EXPECT_NEAR(n, kTrials / 2, 150);
  EXPECT_NEAR(sum / kTrials, 0.18 * 0.18 / 3, 0.0006);
}

TEST(Shuffle, SubsetsHaveTheWantedSizeAndEveryObjectTakesPart) {
  proto::SceneConfig config;
  config.set_objects_in_scene(2);
  const Scene scene = make(config, four_objects());
  int seen[4] = {};
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const Placements p = *scene.shuffle(seed);
    int count = 0;
    for (std::size_t i = 0; i < 4; ++i) count += p.present[i], seen[i] += p.present[i];
    ASSERT_EQ(count, 2);
    EXPECT_EQ(p.present, scene_subset(seed, 4, 2));
  }
  for (const int n : seen) EXPECT_NEAR(n, 500, 80);
}

TEST(Shuffle, ACrowdedTableIsSolvedByBeginningAgain) {
  proto::SceneConfig config;
  config.set_placement_half_x(0.09), config.set_placement_half_y(0.09);
  config.set_placement_tries(100000);
  const std::vector<proto::ObjectBundle> objects(4, testing::ball(0.045));
  const Scene scene = make(config, objects);
  for (std::uint64_t seed = 0; seed < 20; ++seed) EXPECT_TRUE(scene.shuffle(seed)) << seed;
}

TEST(Shuffle, AnImpossibleSceneSaysWhatToChange) {
  proto::SceneConfig config;
  config.set_placement_half_x(0.03), config.set_placement_half_y(0.03);
  const Result<Placements> p = make(config, four_objects()).shuffle(1);
  ASSERT_FALSE(p);
  EXPECT_THAT(p.error().message, HasSubstr("1000 tries"));
  EXPECT_THAT(p.error().message, HasSubstr("placement_half_x"));
}

TEST(Shuffle, AnAreaOutOfTheViewSaysSo) {
  proto::CameraConfig narrow;
  narrow.set_fx(20000), narrow.set_fy(20000);
  const Scene scene = *Scene::create({}, *Camera::create(narrow), four_objects());
  ASSERT_FALSE(scene.shuffle(1));
  EXPECT_THAT(scene.shuffle(1).error().message, HasSubstr("move the camera"));
}

TEST(Scene, RefusesObjectsThatCannotStand) {
  const Camera camera = *Camera::create(proto::CameraConfig());
  proto::ObjectBundle object = testing::ball(0.03);
  object.clear_resting();
  EXPECT_THAT(Scene::create({}, camera, {object}).error().message, HasSubstr("resting"));
  object = testing::ball(0.03);
  object.set_footprint_radius(std::nan(""));
  EXPECT_THAT(Scene::create({}, camera, {object}).error().message, HasSubstr("does not fit"));
  object = testing::ball(0.03);
  object.clear_part();
  EXPECT_THAT(Scene::create({}, camera, {object}).error().message, HasSubstr("no parts"));
}

}  // namespace
}  // namespace evograsp::sim

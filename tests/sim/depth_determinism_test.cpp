// What a camera sees has the same bits on every processor, with either compiler, at any optimisation. The
// digests below came from one machine; the test runs on all of them (and under an emulator of others).
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <thread>

#include "common/digest.h"
#include "scene_objects.h"
#include "sim/depth.h"
#include "sim/scene.h"

namespace evograsp::sim {
namespace {

void append(std::string* bytes, double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  bytes->append(reinterpret_cast<const char*>(&bits), sizeof bits);
}

std::vector<proto::ObjectBundle> every_kind() {
  return {testing::box(0.02, 0.03, 0.05), testing::cylinder(0.03, 0.05), testing::capsule(0.02, 0.03),
          testing::hull_box(0.03, 0.02, 0.03), testing::rippled(0.03, 40, 80)};
}

std::string digest(const proto::Experiment& experiment, std::uint64_t first, std::uint64_t last) {
  const DepthCamera camera = *DepthCamera::create(experiment, every_kind());
  const Scene scene = *Scene::create(experiment.scene(), camera.camera(), every_kind());
  std::string bytes;
  for (std::uint64_t seed = first; seed < last; ++seed) {
    const Placements p = *scene.shuffle(seed);
    for (int target = 0; target < 5; ++target) {
      if (!p.present[static_cast<std::size_t>(target)]) continue;
      const Result<Info> info = camera.look(p, target, 0, seed % 2 == 0);
      if (!info) continue;  // hidden by another object
      for (const float z : info->depth) append(&bytes, z);
      for (const double x : {info->click_a, info->click_b, info->box_w, info->box_h}) append(&bytes, x);
      for (int k = 0; k < 3; ++k) append(&bytes, info->point[k]), append(&bytes, info->anchor[k]);
    }
  }
  return sha256_hex(bytes);
}

proto::Experiment clean() {
  proto::Experiment experiment = testing::experiment();
  experiment.mutable_scene()->set_objects_in_scene(3);
  return experiment;
}

TEST(DepthDeterminism, EqualsTheRecordedDigest) {
  EXPECT_EQ(digest(clean(), 0, 60), "b82b826c907080369debc0f9135e51182f8ecd7085652d9a5e5fa8e296fc61e9");
}

TEST(DepthDeterminism, WithNoiseToo) {
  proto::Experiment experiment = clean();
  experiment.mutable_camera()->mutable_noise()->set_dropout(0.05);
  EXPECT_EQ(digest(experiment, 0, 60), "06bc542648cb1d033d6f211d599f5517c240d2c0bf1290b4eff3d4fb3ab1c6f8");
}

TEST(DepthDeterminism, ThreadsSeeTheSame) {
  std::string seen[4];
  std::vector<std::thread> threads;
  for (std::string& out : seen) threads.emplace_back([&out] { out = digest(clean(), 100, 130); });
  for (std::thread& thread : threads) thread.join();
  for (const std::string& out : seen) EXPECT_EQ(out, seen[0]);
}

}  // namespace
}  // namespace evograsp::sim

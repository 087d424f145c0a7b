// depth/300: the 300 rays of one cmd_get_info on a re-posed scene.
#include <benchmark/benchmark.h>

#include "sim/depth.h"
#include "sim/scene.h"
#include "tests/sim/scene_objects.h"

namespace evograsp::sim {
namespace {

proto::Experiment defaults() {
  return testing::experiment();
}

// Every object of `objects` on the table; each iteration looks at another placement.
void look(benchmark::State& state, const std::vector<proto::ObjectBundle>& objects, bool bounding_box) {
  const DepthCamera camera = *DepthCamera::create(defaults(), objects);
  const Scene scene = *Scene::create(defaults().scene(), camera.camera(), objects);
  std::vector<Placements> placements;
  for (std::uint64_t seed = 0; seed < 64; ++seed) placements.push_back(*scene.shuffle(seed));
  std::vector<float> depth;
  std::size_t i = 0;
  for (auto _ : state) {
    camera.render(placements[i++ % placements.size()], 0, bounding_box, &depth);
    benchmark::DoNotOptimize(depth.data());
  }
  state.counters["rays"] = 300;
}

// The scene of the prototype's peers: cylinder, cube, ball and a concave mesh of 10,000 triangles, all on the
// table.
void depth_300(benchmark::State& state) {
  look(state,
       {testing::cylinder(0.03, 0.06), testing::box(0.03, 0.03, 0.03), testing::ball(0.04),
        testing::rippled(0.045, 50, 100)},
       false);
}
void depth_300_mesh_window(benchmark::State& state) {
  look(state, {testing::rippled(0.045, 50, 100)}, true);
}
void depth_300_box_window(benchmark::State& state) {
  look(state, {testing::box(0.03, 0.03, 0.03)}, true);
}

BENCHMARK(depth_300)->Name("depth/300")->Unit(benchmark::kMicrosecond);
BENCHMARK(depth_300_mesh_window)->Name("depth/300_mesh_10000_window")->Unit(benchmark::kMicrosecond);
BENCHMARK(depth_300_box_window)->Name("depth/300_cube_window")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace evograsp::sim

#include "worker/calibration.h"

#include <algorithm>
#include <array>
#include <chrono>

namespace evograsp::worker {

namespace {

constexpr std::uint64_t kMostScenes = 8;
constexpr auto kPatience = std::chrono::milliseconds(10);

}  // namespace

// The outputs of a network that asks for nothing in particular: the hand comes close to the target.
double measure_grasp(const sim::Simulator& simulator) {
  using Clock = std::chrono::steady_clock;
  const auto workspace = simulator.make_workspace();
  const bool box = simulator.experiment().trials().bounding_box();
  const std::array<float, sim::kOutputs> outputs{};
  Clock::duration spent{};
  int grasps = 0;
  const Clock::time_point end = Clock::now() + kPatience;
  for (std::uint64_t seed = 0; seed < kMostScenes && Clock::now() < end; ++seed) {
    const auto placements = simulator.shuffle(seed);
    if (!placements) continue;
    const auto present = std::find_if(placements->present.begin(), placements->present.end(),
                                      [](const auto there) { return there != 0; });
    if (present == placements->present.end()) continue;
    const auto target = static_cast<int>(present - placements->present.begin());
    const auto info = simulator.get_info(*placements, target, 0, box);
    if (!info) continue;
    const Clock::time_point start = Clock::now();
    simulator.get_quality(*placements, target, simulator.decode(outputs, *info, box), *workspace, nullptr);
    spent += Clock::now() - start;
    ++grasps;
  }
  return grasps == 0 ? 0 : std::chrono::duration<double>(spent).count() / grasps;
}

}  // namespace evograsp::worker

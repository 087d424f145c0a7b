// Which objects of an experiment stand in the scene of a trial seed (SceneConfig.objects_in_scene). A
// function of the seed alone, so that whoever draws trials knows which targets a scene has without simulating
// it.
#pragma once

#include <cstdint>
#include <vector>

#include "common/random.h"

namespace evograsp {

// One flag an object: 1 when it is in the scene. `wanted` = 0 or >= total: all of them. Every subset of
// `wanted` objects is equally likely (selection sampling; Knuth, TAOCP vol. 2, 3.4.2, algorithm S).
inline std::vector<std::uint8_t> scene_subset(std::uint64_t seed, std::uint32_t total, std::uint32_t wanted) {
  std::vector<std::uint8_t> present(total, 1);
  if (wanted == 0 || wanted >= total) return present;
  Random random(seed, Purpose::kPlacement, 0, ~std::uint64_t{0});
  std::uint32_t left = wanted;
  for (std::uint32_t i = 0; i < total; ++i) {
    present[i] = random.below(total - i) < left ? 1 : 0;
    left -= present[i];
  }
  return present;
}

}  // namespace evograsp

// sim_digest [TRIALS]: the digest of that many trials (default 2000) over the built-in objects and hands.
// Builds by any compiler at any optimisation, on any x86-64 processor, print the same lines.
#include <cstdio>
#include <cstdlib>

#include "tests/sim/digest.h"

int main(int argc, char** argv) {
  using namespace evograsp;
  using namespace evograsp::sim::testing;
  const auto trials = static_cast<std::uint64_t>(argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 2000);
  struct Scene {
    std::vector<std::string> objects;
    std::string hand;
  };
  std::vector<Scene> scenes;
  for (const std::string& name : assets::builtin_objects()) scenes.push_back({{name}, "meka_h2"});
  for (const std::string& hand : assets::builtin_hands()) scenes.push_back({{"cube", "sphere", "mug"}, hand});
  std::uint64_t all = 0;
  for (const Scene& scene : scenes) {
    const auto sim = make_simulator(scene.objects, scene.hand);
    const auto workspace = sim->make_workspace();
    std::uint64_t sum = 0;
    for (std::uint64_t i = 0; i < trials / scenes.size(); ++i) sum += digest_trial(*sim, i, *workspace, true);
    std::printf("%016llx  %s x%zu with %s\n", static_cast<unsigned long long>(sum),
                scene.objects.front().c_str(), scene.objects.size(), scene.hand.c_str());
    all = mix64(all ^ sum);
  }
  std::printf("%016llx  all\n", static_cast<unsigned long long>(all));
  return 0;
}

// sim_digest [TRIALS]: the digest of that many trials (default 2000) over the built-in objects and hands, and
// of a lift test for every second of these. Builds by any compiler at any optimisation, on any x86-64
// processor, print the same lines.
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
  const std::uint64_t share = trials / scenes.size();
  std::uint64_t all = 0, lifted = 0;
  int lifts = 0;
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    const Scene& scene = scenes[s];
    const auto sim = make_simulator(scene.objects, scene.hand);
    const auto workspace = sim->make_workspace();
    std::uint64_t sum = 0;
    for (std::uint64_t i = 0; i < share; ++i) sum += digest_trial(*sim, i, *workspace, true);
    std::printf("%016llx  %s x%zu with %s\n", static_cast<unsigned long long>(sum),
                scene.objects.front().c_str(), scene.objects.size(), scene.hand.c_str());
    all = mix64(all ^ sum);
    if (s % 3 == 2) continue;
    const auto lift = digest_lift(*sim, share, *workspace);
    lifted = mix64(lifted ^ lift.value_or(0));
    lifts += lift ? 1 : 0;
  }
  std::printf("%016llx  %d lifts\n", static_cast<unsigned long long>(lifted), lifts);
  std::printf("%016llx  all\n", static_cast<unsigned long long>(mix64(all ^ lifted)));
  return 0;
}

// A champion file as `evograsp infer`, `test`, `render` take it, and its network on hostile images.
#include <cmath>
#include <limits>
#include <vector>

#include "cli/inputs.h"
#include "common/network.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace evograsp;

void activate(const Network& network) {
  const auto inputs = static_cast<std::size_t>(network.inputs()),
             outputs = static_cast<std::size_t>(network.outputs());
  if (inputs + outputs > 10'000 || network.links() > 100'000) return;
  Network::Scratch scratch;
  std::vector<float> in(17 * inputs, 1e30f), out(17 * outputs);
  for (std::size_t i = 0; i < inputs; ++i) in[i] = 0.5f;
  network.activate_batch(in, out, 17, scratch, kRecurrentSteps);
  for (const float value : out) fuzz::require(std::isfinite(value), "finite inputs give finite outputs");
  std::vector<float> first(outputs);
  network.activate(std::span(in).first(inputs), first, scratch, kRecurrentSteps);
  for (std::size_t i = 0; i < outputs; ++i)
    fuzz::require(first[i] == out[i], "a batch gives the bits of one");
  if (inputs == 0) return;
  in[0] = std::numeric_limits<float>::quiet_NaN();
  network.activate(std::span(in).first(inputs), first, scratch, kRecurrentSteps);
  for (const float value : first) fuzz::require(std::isnan(value), "NaN in, NaN out");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  const auto champion =
      cli::read_champion(folder.write("champion.pb", {reinterpret_cast<const char*>(data), size}));
  if (!champion) return 0;
  const auto network = Network::from_proto(champion->network());
  fuzz::require(network.has_value(), "a champion that was read has a network");
  activate(*network);
  return 0;
}

// A hand from a stranger: a URDF, or a hand file and its URDF with a line "%%" between. What the loader
// accepts, the simulator takes.
#include "tests/fuzz/simulate.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace evograsp;
  static const fuzz::Folder folder;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t cut = text.find("\n%%\n");
  std::string file = folder.write("hand.urdf", cut == text.npos ? text : text.substr(cut + 4));
  if (cut != text.npos) file = folder.write("hand.txtpb", text.substr(0, cut));
  const auto hand = assets::load_hand(file, {});
  if (!hand) {
    // The hand file, the URDF, or another that one of them names.
    fuzz::require(hand.error().message.find(folder.path().string()) != std::string::npos,
                  "a refusal names the file");
    return 0;
  }
  const auto& experiment = fuzz::small_experiment();
  const auto simulator = sim::Simulator::create(experiment.experiment, experiment.objects, hand->bundle);
  if (simulator) fuzz::run_trial(**simulator);
  return 0;
}

// An object file from a stranger. What the loader accepts, the simulator takes.
#include "tests/fuzz/simulate.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace evograsp;
  static const fuzz::Folder folder;
  const std::string file = folder.write("object.txtpb", {reinterpret_cast<const char*>(data), size});
  const auto object = assets::load_object(file, {1, 0, {}, folder.path() / "cache"});
  if (!object) {
    fuzz::require(object.error().message.find("object.txtpb") != std::string::npos,
                  "a refusal names the file");
    return 0;
  }
  const auto simulator = sim::Simulator::create(fuzz::small_experiment().experiment, {object->bundle},
                                                fuzz::small_experiment().hand);
  if (simulator) fuzz::run_trial(**simulator);
  return 0;
}

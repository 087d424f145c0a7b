// What a worker is sent or a run.db holds: experiment, object and hand as bytes. The simulator made of them
// runs trials or says why not.
#include <zstd.h>

#include "common/digest.h"
#include "tests/fuzz/simulate.h"

namespace {

using namespace evograsp;

// Legal but slow settings are for benchmarks.
bool quick(const proto::Experiment& experiment) {
  const proto::CameraConfig& camera = experiment.camera();
  return std::uint64_t{camera.columns()} * camera.rows() <= 10'000 &&
         std::uint64_t{camera.image_width()} * camera.image_height() <= 1'000'000 &&
         experiment.scene().placement_tries() <= 1000;
}

std::string packed(std::string_view bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Pieces pieces(data, size);
  const auto& built_in = fuzz::small_experiment();
  proto::Experiment experiment = built_in.experiment;
  std::vector<proto::ObjectBundle> objects(1);
  proto::HandBundle hand;
  const std::string_view object = pieces.bytes(), hand_bytes = pieces.bytes();
  const auto unpacked = assets::unpack_object(packed(object), sha256_hex(object));
  const auto unpacked_hand = assets::unpack_hand(packed(hand_bytes), sha256_hex(hand_bytes));
  if (!unpacked || !unpacked_hand) return 0;
  objects[0] = object.empty() ? built_in.objects[0] : *unpacked;
  hand = hand_bytes.empty() ? built_in.hand : *unpacked_hand;
  const std::string_view changes = pieces.bytes();
  if (!experiment.MergeFromString(std::string(changes)) || !quick(experiment)) return 0;
  const auto simulator = sim::Simulator::create(experiment, objects, hand);
  if (simulator) fuzz::run_trial(**simulator);
  return 0;
}

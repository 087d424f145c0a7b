// What a worker is sent or a run.db holds: experiment, object and hand as bytes. The simulator made of them
// runs trials or says why not.
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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Pieces pieces(data, size);
  const auto& built_in = fuzz::small_experiment();
  proto::Experiment experiment = built_in.experiment;
  std::vector<proto::ObjectBundle> objects(1);
  proto::HandBundle hand;
  const auto take = [&](google::protobuf::MessageLite& message,
                        const google::protobuf::MessageLite& instead) {
    const std::string_view bytes = pieces.bytes();
    if (bytes.empty()) message.CheckTypeAndMergeFrom(instead);
    return message.ParsePartialFromArray(bytes.data(), static_cast<int>(bytes.size())) || bytes.empty();
  };
  if (!take(objects[0], built_in.objects[0]) || !take(hand, built_in.hand)) return 0;
  const std::string_view changes = pieces.bytes();
  if (!experiment.MergeFromString(std::string(changes)) || !quick(experiment)) return 0;
  const auto simulator = sim::Simulator::create(experiment, objects, hand);
  if (simulator) fuzz::run_trial(**simulator);
  return 0;
}

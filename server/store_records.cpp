#include "server/store_records.h"

#include <chrono>

#include "assets/experiment.h"

namespace evograsp::server {

const char* to_string(Severity severity) {
  switch (severity) {
    case Severity::kInfo:
      return "info";
    case Severity::kWarning:
      return "warning";
    case Severity::kError:
      return "error";
  }
  return "info";
}

double unix_time() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string pack_measurements(std::span<const proto::Measurement> measurements) {
  constexpr char kTag = (proto::Measurements::kMeasurementFieldNumber << 3) | 2;  // length-delimited
  std::string packed;
  packed.reserve(measurements.size() * 160);
  for (const proto::Measurement& m : measurements) {
    packed.push_back(kTag);
    for (std::size_t size = m.ByteSizeLong();; size >>= 7) {
      packed.push_back(static_cast<char>(size < 0x80 ? size : (size & 0x7f) | 0x80));
      if (size < 0x80) break;
    }
    m.AppendToString(&packed);
  }
  return packed;
}

Result<std::vector<proto::Measurement>> unpack_measurements(std::string_view packed) {
  proto::Measurements all;
  if (!all.ParseFromArray(packed.data(), static_cast<int>(packed.size())))
    return fail(ErrorCode::kInvalid, "measurements: the bytes do not parse");
  return std::vector<proto::Measurement>(all.measurement().begin(), all.measurement().end());
}

Result<proto::Champion> make_champion(const proto::Config& config, const std::string& fingerprint,
                                      const BestRecord& best,
                                      const std::optional<ValidationRecord>& validation) {
  proto::Champion champion;
  if (!champion.mutable_network()->ParseFromString(best.network) ||
      !champion.mutable_genome()->ParseFromString(best.genotype))
    return fail(ErrorCode::kInvalid,
                "genome " + std::to_string(best.genome) + ": its stored genotype or network does not parse");
  champion.set_version(1);
  proto::Config& experiment = *champion.mutable_experiment();
  *experiment.mutable_scene() = config.scene();
  *experiment.mutable_camera() = config.camera();
  *experiment.mutable_grasp() = config.grasp();
  *experiment.mutable_fitness() = config.fitness();
  *experiment.mutable_trials() = config.trials();
  assets::make_names_stable(experiment.mutable_scene(), experiment.mutable_grasp());
  champion.set_fingerprint(fingerprint);
  champion.set_run_seed(config.run().seed());
  champion.set_generation(best.generation);
  champion.set_fitness(best.fitness);
  if (validation) {
    champion.set_validation_trials(validation->trials);
    champion.set_validation_successes(validation->successes);
    champion.set_validation_fitness(validation->fitness);
    if (validation->lift_trials > 0) {
      champion.set_validation_lift_trials(validation->lift_trials);
      champion.set_validation_lifts(validation->lifts);
    }
  }
  return champion;
}

}  // namespace evograsp::server

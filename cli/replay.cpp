#include "cli/replay.h"

#include <cstdio>

#include "cli/json_values.h"
#include "cli/report.h"
#include "common/network_pack.h"
#include "common/wire.h"
#include "score/score.h"
#include "server/store_reader.h"
#include "worker/evaluator.h"
#include "worker/loader.h"

namespace evograsp::cli {
namespace {

using Json = nlohmann::ordered_json;

Result<server::PoisonRecord> choose(std::vector<server::PoisonRecord> poisons, const std::string& folder,
                                    std::optional<std::uint64_t> genome) {
  std::string known;
  for (server::PoisonRecord& poison : poisons) {
    if (genome ? poison.genome == *genome : poisons.size() == 1) return std::move(poison);
    known += (known.empty() ? "" : ", ") + std::to_string(poison.genome) + " (generation " +
             std::to_string(poison.generation) + ")";
  }
  if (known.empty()) return fail(ErrorCode::kNotFound, folder + ": no genome of this run is poisoned");
  if (genome)
    return fail(ErrorCode::kNotFound,
                folder + ": genome " + std::to_string(*genome) + " is not poisoned; these are: " + known);
  return fail(ErrorCode::kUsage, folder + ": several genomes are poisoned; choose by --genome: " + known);
}

struct Replay {
  server::RunInfo run;
  server::PoisonRecord poison;
  proto::TrialKeys keys;
  std::shared_ptr<worker::SharedSimulator> shared;
};

Result<Replay> open(const std::string& folder, std::optional<std::uint64_t> genome) {
  auto reader = server::StoreReader::open(folder);
  if (!reader) return tl::unexpected(reader.error());
  auto info = (*reader)->run();
  if (!info) return tl::unexpected(info.error());
  auto poisons = (*reader)->poisons();
  if (!poisons) return tl::unexpected(poisons.error());
  auto stored = (*reader)->assets();
  if (!stored) return tl::unexpected(stored.error());
  auto poison = choose(std::move(*poisons), folder, genome);
  if (!poison) return tl::unexpected(poison.error());
  Replay replay{std::move(*info), std::move(*poison), {}, std::make_shared<worker::SharedSimulator>()};
  if (!replay.keys.ParseFromString(replay.poison.trials))
    return fail(ErrorCode::kInvalid, folder + ": the trials of the poisoned genome do not parse");
  worker::Loader loader;
  if (Status status = loader.begin(replay.run.experiment); !status) return tl::unexpected(status.error());
  for (const server::StoredAsset& asset : *stored)
    if (Status status = loader.accept(asset.id, asset.packed); !status) return tl::unexpected(status.error());
  if (const auto missing = loader.missing(); !missing.empty())
    return fail(ErrorCode::kNotFound, folder + ": asset " + missing.front() + " is not in run.db");
  auto simulator = loader.build();
  if (!simulator) return tl::unexpected(simulator.error());
  replay.shared->simulator = std::move(*simulator);
  return replay;
}

// One trial as a worker would run it.
proto::TaskResult run_trial(worker::Evaluator& evaluator, const Replay& replay, const proto::TrialKey& key) {
  proto::Task task;
  task.add_network(replay.poison.genome);
  *task.add_trial() = key;
  task.set_trial_set(key.seed());
  std::vector<zmq::message_t> networks;
  proto::TaskResult result;
  const auto packed = pack_serialised(replay.poison.network);
  if (!packed) {
    result.set_error(packed.error().message);
    return result;
  }
  networks.push_back(to_frame(*packed));
  evaluator.evaluate(task, networks, result);
  return result;
}

}  // namespace

int replay(const std::string& run_folder, std::optional<std::uint64_t> genome, bool json) {
  auto opened = open(run_folder, genome);
  if (!opened) return report(opened.error());
  auto scorer = score::Scorer::create(opened->run.config.fitness());
  if (!scorer) return report(scorer.error());
  worker::Evaluator evaluator(opened->shared);
  const server::PoisonRecord& poison = opened->poison;
  std::fprintf(stderr, "genome %llu of generation %u: %s\n", static_cast<unsigned long long>(poison.genome),
               poison.generation, poison.reason.c_str());
  Json trials = Json::array();
  for (int i = 0; i < opened->keys.trial_size(); ++i) {
    const proto::TrialKey& key = opened->keys.trial(i);
    std::fprintf(stderr, "trial %d of %d: seed %llu, target %u, click %u ... ", i + 1,
                 opened->keys.trial_size(), static_cast<unsigned long long>(key.seed()), key.target(),
                 key.click());
    std::fflush(stderr);
    const proto::TaskResult result = run_trial(evaluator, *opened, key);
    if (result.has_error()) {
      std::fprintf(stderr, "\n");
      return report({ErrorCode::kInvalid, result.error()});
    }
    const proto::Measurement& m = result.measurement(0);
    const double fitness = scorer->trial(m).total;
    std::fprintf(stderr, "%s, quality %.4f, fitness %.4f\n", outcome_name(m.outcome()), m.quality(), fitness);
    trials.push_back({{"seed", key.seed()},
                      {"target", key.target()},
                      {"click", key.click()},
                      {"outcome", outcome_name(m.outcome())},
                      {"quality", m.quality()},
                      {"fitness", fitness}});
  }
  if (json) {
    const Json out = {{"genome", poison.genome},
                      {"generation", poison.generation},
                      {"reason", poison.reason},
                      {"trials", std::move(trials)}};
    std::printf("%s\n", out.dump(1).c_str());
  }
  return kExitOk;
}

}  // namespace evograsp::cli

#include "cli/champion_assets.h"

#include <map>

#include "server/store_reader.h"

namespace evograsp::cli {

namespace fs = std::filesystem;

assets::Bundles trained_bundles(const fs::path& path, const proto::Champion& champion) {
  std::error_code error;
  const fs::path folder = fs::is_directory(path, error) ? path : path.parent_path();
  const fs::path run = folder.empty() ? fs::path(".") : folder;
  if (!fs::exists(run / "run.db", error)) return {};
  auto reader = server::StoreReader::open(run);
  if (!reader) return {};
  const auto info = (*reader)->run();
  const auto stored = (*reader)->assets();
  if (!info || !stored || info->experiment.fingerprint() != champion.fingerprint() ||
      info->experiment.object_id_size() != champion.experiment().scene().object_size())
    return {};
  std::map<std::string, const server::StoredAsset*> by_id;
  for (const server::StoredAsset& asset : *stored) by_id[asset.id] = &asset;

  assets::Bundles out;
  for (const std::string& id : info->experiment.object_id()) {
    if (!by_id.contains(id)) return {};
    auto object = assets::unpack_object(by_id[id]->packed, id);
    if (!object) return {};
    out.objects.push_back(std::move(*object));
  }
  const std::string& hand_id = info->experiment.hand_id();
  if (!by_id.contains(hand_id)) return {};
  auto hand = assets::unpack_hand(by_id[hand_id]->packed, hand_id);
  if (!hand) return {};
  out.hand = std::move(*hand);
  return out;
}

Result<assets::ResolvedExperiment> resolve_trained(const proto::Config& config,
                                                   const assets::Bundles& at_hand, const std::string& flag) {
  auto experiment = assets::resolve_experiment(config, {}, at_hand);
  if (!experiment && experiment.error().code == ErrorCode::kNotFound) {
    return fail(ErrorCode::kNotFound, experiment.error().message + "; name the file by " + flag +
                                          ", or keep the champion beside its run.db");
  }
  return experiment;
}

}  // namespace evograsp::cli

#include "cli/champion_assets.h"

#include <algorithm>
#include <map>
#include <optional>

#include "cli/report.h"
#include "server/store_reader.h"

namespace evograsp::cli {

namespace fs = std::filesystem;

namespace {

// The bundles that a run.db keeps; nothing when it is another experiment's.
Result<std::optional<assets::Bundles>> kept_bundles(server::StoreReader& reader,
                                                    const proto::Champion& champion) {
  const auto info = reader.run();
  if (!info) return tl::unexpected(info.error());
  if (info->experiment.fingerprint() != champion.fingerprint()) return std::optional<assets::Bundles>();
  const auto stored = reader.assets();
  if (!stored) return tl::unexpected(stored.error());
  std::map<std::string, const server::StoredAsset*> by_id;
  for (const server::StoredAsset& asset : *stored) by_id[asset.id] = &asset;

  assets::Bundles out;
  for (const std::string& id : info->experiment.object_id()) {
    if (!by_id.contains(id)) return fail(ErrorCode::kInvalid, "object " + id + " is missing");
    auto object = assets::unpack_object(by_id[id]->packed, id);
    if (!object) return tl::unexpected(object.error());
    out.objects.push_back(std::move(*object));
  }
  if (info->experiment.object_id_size() != champion.experiment().scene().object_size())
    return fail(ErrorCode::kInvalid, "it has another number of objects than the champion");
  const std::string& hand_id = info->experiment.hand_id();
  if (!by_id.contains(hand_id)) return fail(ErrorCode::kInvalid, "hand " + hand_id + " is missing");
  auto hand = assets::unpack_hand(by_id[hand_id]->packed, hand_id);
  if (!hand) return tl::unexpected(hand.error());
  out.hand = std::move(*hand);
  return out;
}

Result<std::optional<assets::Bundles>> beside(const fs::path& path, const proto::Champion& champion,
                                              const NamedAssets& named) {
  std::error_code error;
  const fs::path folder = fs::is_directory(path, error) ? path : path.parent_path();
  const fs::path run = folder.empty() ? fs::path(".") : folder;
  if (fs::symlink_status(run / "run.db", error).type() == fs::file_type::not_found)
    return std::optional<assets::Bundles>();
  auto reader = server::StoreReader::open(run);
  auto kept = reader ? kept_bundles(**reader, champion)
                     : Result<std::optional<assets::Bundles>>(tl::unexpected(reader.error()));
  if (kept) return kept;
  return fail(kept.error().code,
              path.string() +
                  ": the run.db beside it should say what it was trained with, but cannot be read (" +
                  kept.error().message + "); mend it, or name everything by " + named.flags);
}

// Of the champion's assets those that are looked up in files.
std::vector<std::string> files_of(const proto::Config& config, const NamedAssets& named) {
  const auto unknown = [](const std::vector<std::string>& built_in, const std::string& name) {
    return std::ranges::find(built_in, name) == built_in.end();
  };
  std::vector<std::string> files;
  if (!named.hand && unknown(assets::builtin_hands(), config.grasp().hand()))
    files.push_back("hand " + config.grasp().hand());
  if (named.objects) return files;
  const auto objects = assets::object_names();
  for (const std::string& name : config.scene().object())
    if (unknown(objects, name)) files.push_back("object " + name);
  return files;
}

std::string listed(const std::vector<std::string>& files) {
  constexpr std::size_t kMost = 3;
  std::string text;
  for (std::size_t i = 0; i < files.size() && i < kMost; ++i) text += (i == 0 ? "" : ", ") + files[i];
  return files.size() > kMost ? text + " and others" : text;
}

}  // namespace

Result<assets::Bundles> trained_bundles(const fs::path& path, const proto::Champion& champion,
                                        const NamedAssets& named) {
  if (named.objects && named.hand) return assets::Bundles();
  auto kept = beside(path, champion, named);
  if (!kept) return tl::unexpected(kept.error());
  if (*kept) return std::move(**kept);

  const std::vector<std::string> files = files_of(champion.experiment(), named);
  const bool whole = !named.objects && !named.hand && !champion.fingerprint().empty();
  if (files.empty() && !whole) return assets::Bundles();
  auto found = resolve_trained(champion.experiment(), {}, named.flags);
  if (!found) return tl::unexpected(found.error());
  if (found->experiment.fingerprint() == champion.fingerprint()) {
    for (const std::string& warning : found->warnings) warn(warning);
    return assets::Bundles{std::move(found->objects), std::move(found->hand)};
  }
  if (!files.empty())
    return fail(
        ErrorCode::kInvalid,
        path.string() + ": what is found here by the names it was trained with (" + listed(files) +
            ") is not what it was trained with: the fingerprints differ; keep the champion beside its "
            "run.db, or name what it shall have by " +
            named.flags);
  warn(path.string() + ": was trained by a version of evograsp with other trials or built-in assets");
  return assets::Bundles();
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

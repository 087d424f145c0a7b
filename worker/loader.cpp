#include "worker/loader.h"

#include <algorithm>
#include <set>

#include "assets/assets.h"

namespace evograsp::worker {
namespace {

constexpr int kMaxObjects = 256;
constexpr std::size_t kMaxAssets = std::size_t{512} << 20;  // bytes, of all together

}  // namespace

Status Loader::begin(const proto::Experiment& experiment) {
  const std::string own = assets::experiment_fingerprint(experiment);
  if (own != experiment.fingerprint())
    return fail(ErrorCode::kUnsupported, "the master's experiment has fingerprint " +
                                             experiment.fingerprint() + ", this build makes it " + own +
                                             ": install the same version on both sides");
  if (experiment.object_id_size() > kMaxObjects)
    return fail(ErrorCode::kInvalid, "the master's experiment has " +
                                         std::to_string(experiment.object_id_size()) +
                                         " objects, more than " + std::to_string(kMaxObjects));
  experiment_ = experiment;
  const std::set<std::string> wanted(experiment.object_id().begin(), experiment.object_id().end());
  std::erase_if(objects_, [&](const auto& entry) { return !wanted.contains(entry.first); });
  std::erase_if(hands_, [&](const auto& entry) { return entry.first != experiment.hand_id(); });
  return {};
}

std::vector<std::string> Loader::missing() const {
  std::set<std::string> ids;
  for (const std::string& id : experiment_.object_id())
    if (!objects_.contains(id)) ids.insert(id);
  if (!hands_.contains(experiment_.hand_id())) ids.insert(experiment_.hand_id());
  return {ids.begin(), ids.end()};
}

Status Loader::accept(const std::string& id, std::string_view packed) {
  if (id == experiment_.hand_id()) {
    auto hand = assets::unpack_hand(packed, id);
    if (!hand) return tl::unexpected(hand.error());
    hands_[id] = std::move(*hand);
    return {};
  }
  const auto& ids = experiment_.object_id();
  if (std::find(ids.begin(), ids.end(), id) == ids.end())
    return fail(ErrorCode::kInvalid, "asset " + id + " was not asked for");
  auto object = assets::unpack_object(packed, id);
  if (!object) return tl::unexpected(object.error());
  std::size_t all = object->ByteSizeLong();
  for (const auto& [other, kept] : objects_) all += kept.ByteSizeLong();
  if (all > kMaxAssets)
    return fail(ErrorCode::kInvalid, "the master's objects take more than the " +
                                         std::to_string(kMaxAssets >> 20) + " MiB allowed together");
  objects_[id] = std::move(*object);
  return {};
}

Result<std::shared_ptr<const sim::Simulator>> Loader::build() const {
  std::vector<proto::ObjectBundle> objects;
  for (const std::string& id : experiment_.object_id()) objects.push_back(objects_.at(id));
  return sim::Simulator::create(experiment_, objects, hands_.at(experiment_.hand_id()));
}

}  // namespace evograsp::worker

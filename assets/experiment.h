// Experiments from assets that are at hand, and the names that experiments go by.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "assets/assets.h"

namespace evograsp::assets {

// The name of an asset without the folder it was found in: experiments, and so fingerprints and champions,
// are the same wherever the files lie. What an asset is, its id says. Built-in names stay as they are.
std::string stable_name(const std::string& name_or_path);
// All names of objects and hand in a scene and a grasp config made stable.
void make_names_stable(proto::SceneConfig* scene, proto::GraspConfig* grasp);

// Assets that need not be looked up: objects in the order of scene.object, or none at all.
struct Bundles {
  std::vector<proto::ObjectBundle> objects;
  std::optional<proto::HandBundle> hand;
};
// As resolve_experiment of assets.h, with the bundles at hand in place of files. kInvalid when there are
// objects at hand, but not as many as scene.object has.
Result<ResolvedExperiment> resolve_experiment(const proto::Config& config, const std::filesystem::path& base,
                                              const Bundles& at_hand);

}  // namespace evograsp::assets

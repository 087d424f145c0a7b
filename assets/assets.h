// From names and files to immutable, content-addressed bundles. All input is untrusted and bounded.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "proto/bundle.pb.h"
#include "proto/config.pb.h"
#include "proto/wire.pb.h"

namespace evograsp::assets {

// A loaded asset and what a user should hear about it (an unclosed mesh, a part left out).
struct LoadedObject {
  proto::ObjectBundle bundle;
  std::string id;  // SHA-256 of the bundle
  std::vector<std::string> warnings;
};
struct LoadedHand {
  proto::HandBundle bundle;
  std::string id;
  std::vector<std::string> warnings;
};

struct ObjectOptions {
  double mesh_scale = 1;        // for mesh files named directly
  double mesh_mass = 0;         // kg; 0: by density
  std::filesystem::path base;   // relative names are looked up here first
  std::filesystem::path cache;  // decompositions; empty: default_cache_folder()
};

// Lowest points of resting poses are at z = 0 exactly: an object on the table touches it without a gap.
// name_or_path: a built-in name (cylinder, cuboid, cube_6cm = cube, cube_5cm, sphere_4cm = sphere,
// sphere_3cm, mug, plated_mug), an object file (*.txtpb) or a mesh file.
Result<LoadedObject> load_object(const std::string& name_or_path, const ObjectOptions& options);
// name_or_path: a built-in name (meka_h2, parallel_jaw, barrett), a hand file, or a bare URDF (defaults
// guessed).
Result<LoadedHand> load_hand(const std::string& name_or_path, const std::filesystem::path& base);

std::vector<std::string> builtin_objects();
std::vector<std::string> object_names();  // the same and their other names (cube, sphere)
std::vector<std::string> builtin_hands();
std::filesystem::path default_cache_folder();  // $EVOGRASP_CACHE, $XDG_CACHE_HOME/evograsp, ~/.cache/evograsp

// A config's experiment with every asset in hand: what a simulator is created from and a master serves.
struct ResolvedExperiment {
  proto::Experiment experiment;  // fingerprint set
  std::vector<proto::ObjectBundle> objects;
  proto::HandBundle hand;
  std::vector<std::string> warnings;
};
// Every default is written out, those that the schema gives in words too (camera.eye, the workspaces,
// grasp.home).
Result<ResolvedExperiment> resolve_experiment(const proto::Config& config, const std::filesystem::path& base);

// SHA-256 of the experiment's deterministic bytes (its own fingerprint left out) and of kTrialVersion.
std::string experiment_fingerprint(proto::Experiment experiment);

// Bundles by content hash, serialised and zstd-compressed: what AssetReply carries. Unpacking is bounded (64
// MiB) and checks the hash, so packed may come from a stranger.
std::string pack_bundle(const google::protobuf::MessageLite& bundle);
Result<proto::ObjectBundle> unpack_object(std::string_view packed, const std::string& id);
Result<proto::HandBundle> unpack_hand(std::string_view packed, const std::string& id);

}  // namespace evograsp::assets

// What a champion was trained with, though the files may be elsewhere by now.
#pragma once

#include <filesystem>
#include <string>

#include "assets/experiment.h"
#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp::cli {

// What a command's own flags name in the place of what a champion was trained with.
struct NamedAssets {
  bool objects = false, hand = false;
  std::string flags = "--objects and --hand";  // by which the rest can be named, for error messages
};

// The champion's objects and hand out of the run.db beside it; `path` as read_champion takes it. Without one,
// or beside another experiment's, files are looked up by the names in the champion and must be those it was
// trained with, by its fingerprint: a hand of the same name would give another pose. Empty when that leaves
// built-in names alone, or nothing that the flags do not name. kInvalid for other files, and for a run.db
// that is damaged; kNotFound for files that are not there. Warnings of the assets are told.
Result<assets::Bundles> trained_bundles(const std::filesystem::path& path, const proto::Champion& champion,
                                        const NamedAssets& named);

// As assets::resolve_experiment. An asset that is not found gets the advice to name it by `flag`, or to keep
// the champion in its run folder.
Result<assets::ResolvedExperiment> resolve_trained(const proto::Config& config,
                                                   const assets::Bundles& at_hand, const std::string& flag);

}  // namespace evograsp::cli

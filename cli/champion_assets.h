// What a champion was trained with, though the files may be elsewhere by now.
#pragma once

#include <filesystem>
#include <string>

#include "assets/experiment.h"
#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp::cli {

// The champion's objects and hand out of the run.db beside it; `path` as read_champion takes it. Empty when
// there is no run.db or when it is another experiment's: then the names in the champion are looked up.
assets::Bundles trained_bundles(const std::filesystem::path& path, const proto::Champion& champion);

// As assets::resolve_experiment. An asset that is not found gets the advice to name it by `flag`, or to keep
// the champion in its run folder.
Result<assets::ResolvedExperiment> resolve_trained(const proto::Config& config,
                                                   const assets::Bundles& at_hand, const std::string& flag);

}  // namespace evograsp::cli

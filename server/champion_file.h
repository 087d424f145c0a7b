// champion.pb: the champion as a file, for those who want no database.
#pragma once

#include <filesystem>

#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp::server {

inline constexpr char kChampionFile[] = "champion.pb";

// Deterministic bytes; written beside, synced and renamed, so that a reader finds the old file or the new
// one.
Status write_champion(const std::filesystem::path& run_dir, const proto::Champion& champion);

}  // namespace evograsp::server

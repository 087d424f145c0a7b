// Decompositions kept on disk between runs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "proto/bundle.pb.h"

namespace evograsp::assets {

// The entry of a key (a file name); nothing when there is none or it is damaged.
std::optional<std::vector<proto::ConvexPart>> cached_parts(const std::filesystem::path& folder,
                                                           const std::string& key);
// Written beside and renamed, so that readers see all of it or nothing. A failure leaves the cache as it was.
void store_parts(const std::filesystem::path& folder, const std::string& key,
                 const std::vector<proto::ConvexPart>& parts);

}  // namespace evograsp::assets

#include "assets/part_cache.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "assets/assets.h"
#include "assets/text.h"
#include "common/digest.h"

namespace evograsp::assets {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxEntry = std::size_t{16} << 20;
constexpr std::size_t kHash = 64;

fs::path entry(const fs::path& folder, const std::string& key) {
  return folder / ("parts-" + key);
}

}  // namespace

fs::path default_cache_folder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value != nullptr ? value : "");
  };
  if (const fs::path own = variable("EVOGRASP_CACHE"); !own.empty()) return own;
  if (const fs::path xdg = variable("XDG_CACHE_HOME"); !xdg.empty()) return xdg / "evograsp";
  if (const fs::path home = variable("HOME"); !home.empty()) return home / ".cache" / "evograsp";
  return {};
}

// An entry is the SHA-256 of the rest, then an ObjectBundle that holds nothing but the parts.
std::optional<std::vector<proto::ConvexPart>> cached_parts(const fs::path& folder, const std::string& key) {
  if (folder.empty()) return std::nullopt;
  const Result<std::string> bytes = read_file(entry(folder, key), kMaxEntry);
  if (!bytes || bytes->size() <= kHash) return std::nullopt;
  const std::string_view body = std::string_view(*bytes).substr(kHash);
  proto::ObjectBundle bundle;
  if (sha256_hex(body) != bytes->substr(0, kHash) ||
      !bundle.ParseFromArray(body.data(), static_cast<int>(body.size()))) {
    return std::nullopt;
  }
  if (bundle.part().empty()) return std::nullopt;
  return std::vector<proto::ConvexPart>(bundle.part().begin(), bundle.part().end());
}

void store_parts(const fs::path& folder, const std::string& key,
                 const std::vector<proto::ConvexPart>& parts) {
  if (folder.empty()) return;
  proto::ObjectBundle bundle;
  for (const proto::ConvexPart& part : parts) *bundle.add_part() = part;
  const std::string body = deterministic_bytes(bundle);
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path target = entry(folder, key),
                 draft = target.string() + "." + std::to_string(getpid()) + ".tmp";
  std::ofstream out(draft, std::ios::binary | std::ios::trunc);
  out << sha256_hex(body) << body;
  out.close();
  if (out) fs::rename(draft, target, error);
  if (!out || error) fs::remove(draft, error);
}

}  // namespace evograsp::assets

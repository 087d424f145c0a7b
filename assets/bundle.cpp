#include "assets/bundle.h"

#include <zstd.h>

#include "assets/assets.h"
#include "common/digest.h"
#include "common/near_miss.h"
#include "embedded/asset_files.h"

namespace evograsp::assets {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxBundle = std::size_t{64} << 20;  // bytes, unpacked
constexpr int kCompressionLevel = 6;

template <class Bundle>
Result<Bundle> unpack(std::string_view packed, const std::string& id) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > kMaxBundle) {
    return fail(ErrorCode::kInvalid,
                "asset " + id + ": not a packed asset, or larger than the 64 MiB allowed");
  }
  std::string bytes(static_cast<std::size_t>(size), '\0');
  const std::size_t got = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
  if (ZSTD_isError(got) || got != bytes.size()) return fail(ErrorCode::kInvalid, "asset " + id + ": damaged");
  if (sha256_hex(bytes) != id)
    return fail(ErrorCode::kInvalid, "asset " + id + ": the content does not match its name");
  Bundle bundle;
  if (!bundle.ParseFromString(bytes))
    return fail(ErrorCode::kInvalid, "asset " + id + ": not an asset of this kind");
  return bundle;
}

}  // namespace

std::string bundle_id(const google::protobuf::MessageLite& bundle) {
  return sha256_hex(deterministic_bytes(bundle));
}

std::optional<std::string_view> embedded_file(std::string_view path) {
  for (const embedded::File& file : embedded::asset_files()) {
    if (file.name == path) return file.data;
  }
  return std::nullopt;
}

std::vector<std::string> builtin_names(std::string_view folder) {
  constexpr std::string_view kExtension = ".txtpb";
  std::vector<std::string> names;
  for (const embedded::File& file : embedded::asset_files()) {
    if (!file.name.starts_with(folder) || !file.name.ends_with(kExtension)) continue;
    names.emplace_back(file.name.substr(folder.size(), file.name.size() - folder.size() - kExtension.size()));
  }
  return names;
}

fs::path find_file(const std::string& name, const fs::path& base) {
  std::error_code error;
  if (name.empty() || name.find('\0') != std::string::npos) return {};
  if (!base.empty() && fs::path(name).is_relative() && fs::exists(base / name, error)) return base / name;
  if (fs::exists(name, error)) return name;
  return {};
}

std::string unknown_name(std::string_view kind, const std::string& name,
                         const std::vector<std::string>& builtin) {
  return name + ": no such " + std::string(kind) + " or file" + did_you_mean(name, builtin) +
         " (built in: " + join_words(builtin) + ")";
}

std::string pack_bundle(const google::protobuf::MessageLite& bundle) {
  const std::string bytes = deterministic_bytes(bundle);
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kCompressionLevel));
  return packed;
}

Result<proto::ObjectBundle> unpack_object(std::string_view packed, const std::string& id) {
  return unpack<proto::ObjectBundle>(packed, id);
}
Result<proto::HandBundle> unpack_hand(std::string_view packed, const std::string& id) {
  return unpack<proto::HandBundle>(packed, id);
}

}  // namespace evograsp::assets

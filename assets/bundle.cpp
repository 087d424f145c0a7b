#include "assets/bundle.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>
#include <zstd.h>

#include "assets/assets.h"
#include "common/digest.h"
#include "common/near_miss.h"
#include "embedded/asset_files.h"

namespace evograsp::assets {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;
using Wire = pb::internal::WireFormatLite;
constexpr int kCompressionLevel = 6;
// A part of no bytes takes two on the wire and two hundred in memory.
constexpr int kMaxValues = 100'000;

// The values of a message on the wire, a packed list counting as one, with those of all messages in it; more
// than `most`, or -1: no need to go on, or not a message of this type.
int values_on_wire(std::string_view bytes, const pb::Descriptor& type, int most) {
  pb::io::CodedInputStream in(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                              static_cast<int>(bytes.size()));
  int values = 0;
  while (const std::uint32_t tag = in.ReadTag()) {
    if (++values > most) return values;
    if (Wire::GetTagWireType(tag) == Wire::WIRETYPE_START_GROUP) return -1;  // no asset has one
    const pb::FieldDescriptor* field = type.FindFieldByNumber(Wire::GetTagFieldNumber(tag));
    const bool is_message = field != nullptr && field->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE;
    if (!is_message || Wire::GetTagWireType(tag) != Wire::WIRETYPE_LENGTH_DELIMITED) {
      if (!Wire::SkipField(&in, tag)) return -1;
      continue;
    }
    std::uint32_t size = 0;
    if (!in.ReadVarint32(&size)) return -1;
    const auto at = static_cast<std::size_t>(in.CurrentPosition());
    if (size > bytes.size() - at || !in.Skip(static_cast<int>(size))) return -1;
    const int inner = values_on_wire(bytes.substr(at, size), *field->message_type(), most - values);
    if (inner < 0) return -1;
    values += inner;
  }
  return in.ConsumedEntireMessage() ? values : -1;
}

template <class Bundle>
Result<Bundle> read_bundle(std::string_view bytes) {
  const int values = values_on_wire(bytes, *Bundle::descriptor(), kMaxValues);
  if (values > kMaxValues)
    return fail(ErrorCode::kInvalid, "holds more than the " + std::to_string(kMaxValues) + " values allowed");
  Bundle bundle;
  if (values < 0 || !bundle.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return fail(ErrorCode::kInvalid, "not an asset of this kind");
  return bundle;
}

template <class Bundle>
Result<Bundle> unpack(std::string_view packed, const std::string& id) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > kMaxBundle) {
    return fail(ErrorCode::kInvalid,
                "asset " + id + ": not a packed asset, or larger than the 16 MiB allowed");
  }
  std::string bytes(static_cast<std::size_t>(size), '\0');
  const std::size_t got = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
  if (ZSTD_isError(got) || got != bytes.size()) return fail(ErrorCode::kInvalid, "asset " + id + ": damaged");
  if (sha256_hex(bytes) != id)
    return fail(ErrorCode::kInvalid, "asset " + id + ": the content does not match its name");
  Result<Bundle> bundle = read_bundle<Bundle>(bytes);
  if (!bundle) return fail(bundle.error().code, "asset " + id + ": " + bundle.error().message);
  return bundle;
}

}  // namespace

std::string bundle_id(const google::protobuf::MessageLite& bundle) {
  return sha256_hex(deterministic_bytes(bundle));
}

Status check_size(const google::protobuf::MessageLite& bundle) {
  const std::size_t bytes = bundle.ByteSizeLong();
  if (bytes <= kMaxBundle) return {};
  return fail(ErrorCode::kInvalid, "its surface takes " + std::to_string(bytes >> 20) +
                                       " MiB, more than the 16 MiB allowed: simplify the mesh");
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

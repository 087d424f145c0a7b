#include "common/network_pack.h"

#include <zstd.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

namespace evograsp {
namespace {

// format, counts (inputs, recurrent, nodes, links, outputs, size of the packed part), packed part:
// activations, biases, links of each node, outputs, distances of sources, exponents; then three bytes a
// weight.
constexpr char kFormat = 1;
constexpr int kLevel = 1;  // higher ones save nothing: what repeats, repeats at once
constexpr std::size_t kBytesAWeight = 3;
constexpr std::uint32_t kMostVarint = 5;

tl::unexpected<Error> bad(const char* what) {
  return fail(ErrorCode::kInvalid, std::string("packed network: ") + what);
}

void put(std::string& out, std::uint32_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<char>(value | 0x80));
  out.push_back(static_cast<char>(value));
}

// Reads within its bytes; `good` says whether all that was asked for was there.
struct Reader {
  std::string_view rest;
  bool good = true;

  std::uint32_t varint() {
    std::uint64_t value = 0;
    for (std::uint32_t i = 0; i < kMostVarint && i < rest.size(); ++i) {
      const auto byte = static_cast<std::uint8_t>(rest[i]);
      value |= static_cast<std::uint64_t>(byte & 0x7f) << (7 * i);
      if (byte >= 0x80) continue;
      rest.remove_prefix(i + 1);
      good = good && value <= UINT32_MAX;
      return static_cast<std::uint32_t>(value);
    }
    good = false;
    return 0;
  }
  std::string_view take(std::size_t size) {
    good = good && size <= rest.size();
    if (!good) return {};
    const std::string_view taken = rest.substr(0, size);
    rest.remove_prefix(size);
    return taken;
  }
};

// Sign and mantissa side by side in the low 24 bits, the exponent above.
std::uint32_t exponent_first(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits & 0x7fffffu) | (bits >> 31) << 23 | (bits >> 23 & 0xffu) << 24;
}
float exponent_first(std::uint32_t mixed) {
  return std::bit_cast<float>((mixed & 0x7fffffu) | (mixed >> 23 & 1u) << 31 | (mixed >> 24) << 23);
}

struct FreeContext {
  void operator()(ZSTD_CCtx* c) const { ZSTD_freeCCtx(c); }
  void operator()(ZSTD_DCtx* c) const { ZSTD_freeDCtx(c); }
};

std::string compress(const std::string& plain) {
  thread_local const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  std::string packed(ZSTD_compressBound(plain.size()), '\0');
  // With room for the worst case nothing but a lack of memory can go wrong.
  if (context == nullptr) throw std::bad_alloc();
  const std::size_t size =
      ZSTD_compressCCtx(context.get(), packed.data(), packed.size(), plain.data(), plain.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();
  packed.resize(size);
  return packed;
}

Result<std::string> decompress(std::string_view packed, std::size_t most) {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > most)
    return bad("its packed part has no believable size");
  std::string plain(size, '\0');
  if (ZSTD_decompressDCtx(context.get(), plain.data(), plain.size(), packed.data(), packed.size()) != size)
    return bad("its packed part is damaged");
  return plain;
}

// What a network's columns are made of when they come from a packed one.
struct Columns {
  std::uint32_t inputs = 0, nodes = 0, links = 0, outputs = 0;
  bool recurrent = false;
  std::vector<std::uint8_t> activation;
  std::vector<float> bias, weight;
  std::vector<std::uint32_t> first_link, source, output_node;
};

Status read_packed_part(std::string_view plain, std::string_view mantissas, Columns& c) {
  Reader in{plain};
  const std::string_view activation = in.take(c.nodes), bias = in.take(std::size_t{c.nodes} * sizeof(float));
  if (!in.good) return bad("too short");
  c.activation.assign(activation.begin(), activation.end());
  c.bias.resize(c.nodes);
  if (!bias.empty()) std::memcpy(c.bias.data(), bias.data(), bias.size());
  c.first_link.assign(1, 0);
  std::uint64_t links = 0;
  for (std::uint32_t i = 0; i < c.nodes; ++i) {
    links += in.varint();
    if (links > c.links) return bad("more links than it says");
    c.first_link.push_back(static_cast<std::uint32_t>(links));
  }
  for (std::uint32_t i = 0; i < c.outputs; ++i) c.output_node.push_back(in.varint());
  for (std::uint32_t i = 0; i < c.nodes; ++i) {
    std::uint32_t source = 0;
    for (std::uint32_t k = c.first_link[i]; k < c.first_link[i + 1]; ++k)
      c.source.push_back(source += in.varint());
  }
  const std::string_view exponents = in.take(c.links);
  if (!in.good || !in.rest.empty() || c.source.size() != c.links) return bad("its parts do not fit");
  c.weight.resize(c.links);
  for (std::uint32_t k = 0; k < c.links; ++k) {
    std::uint32_t mixed = 0;
    std::memcpy(&mixed, mantissas.data() + k * kBytesAWeight, kBytesAWeight);
    c.weight[k] =
        exponent_first(mixed | static_cast<std::uint32_t>(static_cast<std::uint8_t>(exponents[k])) << 24);
  }
  return {};
}

}  // namespace

std::string pack_network(const proto::Network& network) {
  const int nodes = network.activation_size(), links = network.weight_size();
  std::string plain;
  plain.reserve(static_cast<std::size_t>(nodes) * 8 + static_cast<std::size_t>(links) * 3);
  for (const std::uint32_t activation : network.activation()) plain.push_back(static_cast<char>(activation));
  plain.append(reinterpret_cast<const char*>(network.bias().data()),
               static_cast<std::size_t>(nodes) * sizeof(float));
  for (int i = 0; i < nodes; ++i) put(plain, network.first_link(i + 1) - network.first_link(i));
  for (const std::uint32_t node : network.output_node()) put(plain, node);
  for (int i = 0; i < nodes; ++i) {
    std::uint32_t before = 0;
    for (auto k = static_cast<int>(network.first_link(i)); k < static_cast<int>(network.first_link(i + 1));
         ++k) {
      put(plain, network.source(k) - before);
      before = network.source(k);
    }
  }
  std::string mantissas(static_cast<std::size_t>(links) * kBytesAWeight, '\0');
  for (int k = 0; k < links; ++k) {
    const std::uint32_t mixed = exponent_first(network.weight(k));
    std::memcpy(mantissas.data() + static_cast<std::size_t>(k) * kBytesAWeight, &mixed, kBytesAWeight);
    plain.push_back(static_cast<char>(mixed >> 24));
  }
  const std::string packed = compress(plain);
  std::string out(1, kFormat);
  for (const std::uint32_t count :
       {network.inputs(), network.recurrent() ? 1u : 0u, static_cast<std::uint32_t>(nodes),
        static_cast<std::uint32_t>(links), static_cast<std::uint32_t>(network.output_node_size()),
        static_cast<std::uint32_t>(packed.size())})
    put(out, count);
  return out + packed + mantissas;
}

Result<std::string> pack_serialised(const std::string& network) {
  proto::Network message;
  if (!message.ParseFromString(network)) return fail(ErrorCode::kInvalid, "not a network");
  const auto sound = Network::from_proto(message);
  if (!sound) return tl::unexpected(sound.error());
  return pack_network(sound->to_proto());
}

Result<Network> unpack_network(std::string_view bytes) {
  Reader in{bytes};
  if (in.take(1) != std::string_view(&kFormat, 1)) return bad("unknown format");
  Columns c;
  c.inputs = in.varint();
  const std::uint32_t recurrent = in.varint();
  c.recurrent = recurrent == 1;
  c.nodes = in.varint();
  c.links = in.varint();
  c.outputs = in.varint();
  const std::string_view packed = in.take(in.varint());
  if (!in.good || recurrent > 1) return bad("its counts are not whole");
  if (c.nodes > Network::kMaxNodes || c.links > Network::kMaxLinks || c.outputs > Network::kMaxNodes)
    return bad("too large");
  if (in.rest.size() != std::size_t{c.links} * kBytesAWeight) return bad("not one mantissa a link");
  const std::size_t most = std::size_t{c.nodes} * (1 + sizeof(float) + kMostVarint) +
                           std::size_t{c.outputs} * kMostVarint + std::size_t{c.links} * (kMostVarint + 1);
  const auto plain = decompress(packed, most);
  if (!plain) return tl::unexpected(plain.error());
  if (Status status = read_packed_part(*plain, in.rest, c); !status) return tl::unexpected(status.error());
  return Network::from_columns({.inputs = c.inputs,
                                .recurrent = c.recurrent,
                                .activation = c.activation,
                                .bias = c.bias,
                                .first_link = c.first_link,
                                .source = c.source,
                                .weight = c.weight,
                                .output_node = c.output_node});
}

}  // namespace evograsp

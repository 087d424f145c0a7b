// A few bytes that unpack to gigabytes are refused in little memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include <functional>

#include "assets/assets.h"
#include "assets/contained.h"
#include "common/network_pack.h"

namespace evograsp::assets {
namespace {

using ::testing::StartsWith;

// `bytes` zeros, compressed piece by piece; says how many when `announced`.
std::string bomb(std::size_t bytes, bool announced) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  if (announced) ZSTD_CCtx_setPledgedSrcSize(context, bytes);
  const std::string zeros(1 << 20, '\0');
  std::string packed(1 << 20, '\0');
  ZSTD_outBuffer out{packed.data(), packed.size(), 0};
  for (std::size_t done = 0; done < bytes; done += zeros.size()) {
    ZSTD_inBuffer in{zeros.data(), zeros.size(), 0};
    const auto how = done + zeros.size() >= bytes ? ZSTD_e_end : ZSTD_e_continue;
    while (in.pos < in.size) EXPECT_FALSE(ZSTD_isError(ZSTD_compressStream2(context, &out, &in, how)));
  }
  ZSTD_inBuffer none{nullptr, 0, 0};
  while (ZSTD_compressStream2(context, &out, &none, ZSTD_e_end) > 0) {
  }
  ZSTD_freeCCtx(context);
  packed.resize(out.pos);
  return packed;
}

// The same bytes with another announced size: the eight bytes after magic, descriptor and window.
std::string lying(std::string packed, std::uint64_t size) {
  const auto descriptor = static_cast<std::uint8_t>(packed[4]);
  EXPECT_EQ(descriptor >> 6, 2) << "a size of four bytes";
  const std::size_t at = (descriptor & 0x20) != 0 ? 5 : 6;
  for (std::size_t i = 0; i < 4; ++i) packed[at + i] = static_cast<char>(size >> (8 * i));
  EXPECT_EQ(ZSTD_getFrameContentSize(packed.data(), packed.size()), size);
  return packed;
}

std::vector<std::string> bombs() {
  constexpr std::size_t kGibibyte = std::size_t{1} << 30;
  const std::string honest = bomb(kGibibyte, true);
  EXPECT_LT(honest.size(), 200000u) << "no bomb";
  return {honest, bomb(kGibibyte, false), lying(honest, 1 << 20), lying(honest, 0xffffffff),
          bomb(1 << 20, true) + honest};
}

// What `unpack` says of it in a process that may take 150 MB.
std::string verdict_of(const std::function<Result<std::string>()>& unpack) {
  Containment limits;
  limits.memory = std::size_t{150} << 20;
  const auto verdict = run_contained(
      [&]() -> Result<std::string> {
        const auto unpacked = unpack();
        return unpacked ? std::string("was taken") : "refused: " + unpacked.error().message;
      },
      limits);
  return verdict ? *verdict : "died: " + verdict.error().message;
}

// verdict_of() that unpacking; none when it gives something.
template <class Unpack>
std::string verdict_of_unpacking(Unpack unpack) {
  return verdict_of([&]() -> Result<std::string> {
    const auto unpacked = unpack();
    if (!unpacked) return tl::unexpected(unpacked.error());
    return std::string();
  });
}

TEST(Bombs, AsAssetsAreRefusedInLittleMemory) {
  const std::string id(64, 'a');
  for (const std::string& packed : bombs()) {
    EXPECT_THAT(verdict_of_unpacking([&] { return unpack_object(packed, id); }),
                StartsWith("refused: asset "));
    EXPECT_THAT(verdict_of_unpacking([&] { return unpack_hand(packed, id); }), StartsWith("refused: asset "));
  }
}

// A packed network of as many nodes as it likes, whose packed part is the bomb.
TEST(Bombs, AsNetworksAreRefusedInLittleMemory) {
  for (const std::string& packed : bombs()) {
    for (const std::uint32_t nodes : {1u, Network::kMaxNodes}) {
      std::string network("\1\1\0", 3);  // format, one input, not recurrent
      for (std::uint32_t number : {nodes, 0u, 1u, static_cast<std::uint32_t>(packed.size())}) {
        for (; number >= 0x80; number >>= 7) network.push_back(static_cast<char>(number | 0x80));
        network.push_back(static_cast<char>(number));
      }
      network += packed;
      EXPECT_EQ(verdict_of([&]() -> Result<std::string> {
                  const auto unpacked = unpack_network(network);
                  if (!unpacked) return tl::unexpected(unpacked.error());
                  return std::string();
                }).substr(0, 24),
                "refused: packed network:");
    }
  }
}

}  // namespace
}  // namespace evograsp::assets

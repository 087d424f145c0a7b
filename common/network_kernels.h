// The inner loops of common/network.h, compiled once an instruction set. Every version adds the same numbers
// in the same order: bits do not depend on which one runs.
//
// The sum of a node, in all of them: 16 partial sums, the link from source s in partial sum s mod 16, sources
// ascending, starting from +0; then sums l and l + 8 are added, then l and l + 4, + 2, + 1; then the bias.
// Adding the +-0 of an absent link changes nothing, so a node may be stored densely in blocks of 16 sources
// (absent links weigh 0) or link by link.
#pragma once

#include <cstdint>

namespace evograsp::kernels {

inline constexpr int kLanes = 16;    // partial sums of a node, and samples of a batch
inline constexpr int kColumns = 64;  // samples of columns(): enough to hide how long one result takes

struct alignas(64) Block {
  float weight[kLanes];
};

struct Node {
  std::uint32_t first_block = 0, blocks = 0;  // blocks == 0: stored link by link
  std::uint32_t first_link = 0, links = 0;
  float bias = 0;
  std::uint8_t activation = 0;
};

// A compiled network as the loops see it. Node i of `node` writes value `first_value + i`.
struct Program {
  const Node* node;
  std::uint32_t nodes;
  std::uint32_t first_value;
  const Block* block;
  const std::uint32_t* block_source;  // first source of each block, a multiple of 16
  const std::uint32_t* source;        // of each link
  const float* weight;
};

constexpr std::uint64_t batch_place(std::uint64_t value, std::uint64_t sample) {
  return (value / kLanes * kLanes + sample) * kLanes + value % kLanes;
}

struct Kernels {
  // Copies `count` numbers; true if all are finite.
  bool (*copy_finite)(const float* in, std::uint32_t count, float* out);
  // The same for 16 rows of `count` numbers, into the layout of batch().
  bool (*copy_finite_rows)(const float* in, std::uint32_t count, float* out);
  // One sample: values of all nodes in `from` (read) and `to` (written); the same array when feed-forward.
  void (*one)(const Program&, const float* from, float* to);
  // 16 samples. Value v of sample r is at [batch_place(v, r)]: what a block of weights meets lies together.
  void (*batch)(const Program&, const float* from, float* to);
  // kColumns samples, one a column: value v of sample c at [v * kColumns + c].
  void (*columns)(const Program&, const float* from, float* to);
};

extern const Kernels kBaseline, kAvx2, kAvx512;

// Those of active_isa().
const Kernels& active();

}  // namespace evograsp::kernels

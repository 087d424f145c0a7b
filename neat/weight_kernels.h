// Inner loops over weights, compiled once an instruction set with equal bits (see common/isa.h).
#pragma once

#include <cstdint>

#include "common/random.h"

namespace evograsp::neat {

// What mutation does to a weight; see mutate_weights().
struct WeightStep {
  std::uint32_t perturb_below;  // perturb if the high half of the draw is below this, or always
  bool always_perturb;
  float perturb, replace, limit;
};

struct WeightKernels {
  // weight[i], i < count, by number i of the stream: high half of the 64 bits chooses, low half gives 24 bits
  // in
  // [-1, 1). scale: of each link; null: 1.
  void (*mutate)(float* weight, const float* scale, std::uint32_t count, Random::Counter draws,
                 const WeightStep&);
  // weight[i] = other[i] where bit i of bits is set.
  void (*choose)(float* weight, const float* other, std::uint32_t count, const std::uint64_t* bits);
  // Sum of |a - b| in 16 partial sums and a fixed tree.
  float (*difference)(const float* a, const float* b, std::uint32_t count);
};

extern const WeightKernels kBaselineWeights, kAvx2Weights, kAvx512Weights;

const WeightKernels& weight_kernels();  // those of active_isa()

}  // namespace evograsp::neat

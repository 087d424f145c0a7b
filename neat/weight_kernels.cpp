#include "neat/weight_kernels.h"

#include "common/isa.h"

namespace evograsp::neat {

const WeightKernels& weight_kernels() {
  switch (active_isa()) {
    case Isa::kAvx512:
      return kAvx512Weights;
    case Isa::kAvx2:
      return kAvx2Weights;
    case Isa::kBaseline:
      break;
  }
  return kBaselineWeights;
}

}  // namespace evograsp::neat

#include "common/network_kernels.h"

#include "common/isa.h"

namespace evograsp::kernels {

const Kernels& active() {
  switch (active_isa()) {
    case Isa::kAvx512:
      return kAvx512;
    case Isa::kAvx2:
      return kAvx2;
    case Isa::kBaseline:
      break;
  }
  return kBaseline;
}

}  // namespace evograsp::kernels

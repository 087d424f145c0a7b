#include "common/isa.h"

#include <atomic>

namespace evograsp {
namespace {

Isa widest() {
  if (runs_here(Isa::kAvx512)) return Isa::kAvx512;
  return runs_here(Isa::kAvx2) ? Isa::kAvx2 : Isa::kBaseline;
}

std::atomic<Isa>& choice() {
  static std::atomic<Isa> isa = widest();
  return isa;
}

}  // namespace

const char* name(Isa isa) {
  switch (isa) {
    case Isa::kAvx512:
      return "avx512";
    case Isa::kAvx2:
      return "avx2";
    case Isa::kBaseline:
      break;
  }
  return "baseline";
}

bool runs_here(Isa isa) {
  switch (isa) {
    case Isa::kAvx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
    case Isa::kAvx2:
      return __builtin_cpu_supports("avx2");
    case Isa::kBaseline:
      break;
  }
  return true;
}

Isa active_isa() {
  return choice().load(std::memory_order_relaxed);
}
void force_isa(Isa isa) {
  choice().store(isa, std::memory_order_relaxed);
}

}  // namespace evograsp

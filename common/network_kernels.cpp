#include "common/network_kernels.h"

#include <atomic>

namespace evograsp::kernels {
namespace {

const Kernels& widest() {
  if (runs_here(kAvx512)) return kAvx512;
  if (runs_here(kAvx2)) return kAvx2;
  return kBaseline;
}

std::atomic<const Kernels*> forced = nullptr;

}  // namespace

bool runs_here(const Kernels& kernels) {
  if (&kernels == &kAvx512) return __builtin_cpu_supports("avx512f") != 0;
  if (&kernels == &kAvx2) return __builtin_cpu_supports("avx2") != 0;
  return true;
}

const Kernels& active() {
  static const Kernels& chosen = widest();
  const Kernels* choice = forced.load(std::memory_order_relaxed);
  return choice != nullptr ? *choice : chosen;
}

void force(const Kernels& kernels) {
  forced.store(&kernels, std::memory_order_relaxed);
}

}  // namespace evograsp::kernels

// How much memory this process holds, to compare before and after.
#pragma once

#include <cstddef>
#include <fstream>

#include "common/sanitized.h"
#ifdef EVOGRASP_SANITIZED
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();  // g++ has it, and no header that says so
#endif

namespace evograsp::testing {

// Bytes: resident, or, where a sanitizer keeps what was freed, allocated.
inline std::size_t memory_held() {
#ifdef EVOGRASP_SANITIZED
  return __sanitizer_get_current_allocated_bytes();
#else
  std::ifstream in("/proc/self/statm");
  std::size_t total = 0, pages = 0;
  in >> total >> pages;
  return pages * 4096;
#endif
}

}  // namespace evograsp::testing

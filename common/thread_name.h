// Names for top -H, gdb and perf.
#pragma once

#include <pthread.h>

namespace evograsp {

// Names the calling thread; at most 15 characters count.
inline void name_thread(const char* name) {
  pthread_setname_np(pthread_self(), name);
}

}  // namespace evograsp

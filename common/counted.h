// Counts in sentences.
#pragma once

#include <string>

namespace evograsp {

// "0 slots", "1 slot", "2 slots"; what: the name of one, whose plural takes an s.
inline std::string counted(long long count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace evograsp

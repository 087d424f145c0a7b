// Data that the repository does not hold: scans, robots, frames, measured grasps of others.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace evograsp::testing {

// $EVOGRASP_DATA, else shared/data beside the source tree. Empty where there is none: a test that needs it
// then checks nothing, and its output says so. Where there is one, tests demand all that belongs in it.
inline std::filesystem::path data_folder() {
  const char* given = std::getenv("EVOGRASP_DATA");
  const std::filesystem::path path = given != nullptr
                                         ? std::filesystem::path(given)
                                         : std::filesystem::path(EVOGRASP_SOURCE_DIR) / "../shared/data";
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return path;
  std::printf("NOTHING CHECKED: no folder of data at %s (set EVOGRASP_DATA)\n", path.c_str());
  return {};
}

}  // namespace evograsp::testing

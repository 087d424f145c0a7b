// Files that travel inside the program: what evograsp_embed() of cmake/embed.cmake puts there.
#pragma once

#include <span>
#include <string_view>

namespace evograsp::embedded {

struct File {
  std::string_view name;  // path relative to the embedded folder
  std::string_view data;  // followed by a zero byte that is not counted
};

}  // namespace evograsp::embedded

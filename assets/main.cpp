// evograsp-meshgen bottle|cup: writes the mesh to standard output.
#include <cstdio>
#include <string>
#include <string_view>

#include "assets/meshgen.h"

int main(int argc, char** argv) {
  const std::string_view what = argc == 2 ? argv[1] : "";
  if (what != "bottle" && what != "cup") {
    std::fputs("usage: evograsp-meshgen bottle|cup > FILE.obj\n", stderr);
    return 2;
  }
  const std::string text =
      what == "bottle" ? evograsp::assets::bottle_obj() : evograsp::assets::handled_cup_obj();
  const bool written =
      std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  return written ? 0 : 5;
}

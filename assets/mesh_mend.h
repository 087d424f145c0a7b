// What assimp reads wrongly, or refuses without a reason, found and where it is valid mended before it sees
// it.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace evograsp::assets {

// The bytes to hand to assimp for a file of that extension. OBJ: numbers that begin with their point get a
// nought before it ('-.5': valid, but assimp does not count them); a last line that is a face of less than
// three corners is a cut. STL: binary files end where their count says; a binary one whose comment begins
// with 'solid' is binary; an ASCII one ends with 'endsolid'. GLB: as long as its header says. glTF: JSON
// whose nodes are trees, as the format demands (glTF 2.0, 3.5.2): children of several parents multiply,
// thirty nodes are a thousand million. Errors name what is wrong, not the file.
Result<std::string> mended(std::string_view bytes, const std::string& extension);

}  // namespace evograsp::assets

// Stands in the place of common/version.h where the worker of another build is compiled.
#pragma once

#define kVersion kRealVersion
#include "../../../../common/version.h"
#undef kVersion

namespace evograsp {
static constexpr char kVersion[] = "0.0.0";
}  // namespace evograsp

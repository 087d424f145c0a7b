// Bullet calls sin, cos, acos, asin and atan2 of the C library, which chooses its variants by processor: last
// bits, and with them a lift on the very edge of slipping, would depend on the machine. The program therefore
// brings these five (and sincos) itself, made of common/det_math.h, and the dynamic linker binds Bullet to
// them.
#pragma once

namespace evograsp::sim {

// Call it from what must not be linked without them: a static library gives only what is asked for.
void keep_own_libm();

}  // namespace evograsp::sim

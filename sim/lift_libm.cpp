#include "sim/lift_libm.h"

#include <math.h>

#include "common/det_math.h"

extern "C" {
double sin(double x) noexcept {
  return evograsp::det::sin(x);
}
double cos(double x) noexcept {
  return evograsp::det::cos(x);
}
void sincos(double x, double* s, double* c) noexcept {
  evograsp::det::sincos(x, s, c);
}
double acos(double x) noexcept {
  return evograsp::det::acos(x);
}
double asin(double x) noexcept {
  return evograsp::det::asin(x);
}
double atan2(double y, double x) noexcept {
  return evograsp::det::atan2(y, x);
}
}

namespace evograsp::sim {

void keep_own_libm() {}

}  // namespace evograsp::sim

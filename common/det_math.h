// Transcendental functions whose bits do not depend on the machine. glibc picks variants with and without
// fused multiply-add at run time, so sin, cos, exp, log, tanh, acos and atan2 of <cmath> must not be used in
// anything that a trial or a network touches; sqrt, fabs, floor, ceil and copysign are exact and fine. Errors
// stay below 1.5 ulp on the ranges named. Pure functions, thread-safe.
#pragma once

namespace evograsp::det {

inline constexpr double kPi = 3.14159265358979323846;

double sin(double x);  // |x| <= 1e5 rad; NaN beyond
double cos(double x);
void sincos(double x, double* s, double* c);
double exp(double x);
double log(double x);  // x > 0
double tanh(double x);
double atan(double x);
double atan2(double y, double x);
double acos(double x);  // clamped to [-1, 1]
double asin(double x);  // clamped to [-1, 1]

}  // namespace evograsp::det

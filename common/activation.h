// The activation functions of a network node: single precision, and the same bits everywhere.
//
// Each is built only from operations that IEEE 754 rounds exactly (+ - * / min max and comparison), in one
// written order, so that a scalar, four, eight or sixteen lanes give the same bits with any compiler. They
// hold for every finite argument and return finite values; the arguments of a compiled network are always
// finite.
//
//   steep sigmoid  1 / (1 + exp(-4.9 x))   Stanley and Miikkulainen 2002, section 4.1
//   tanh           tanh x
//   relu, linear   max(x, 0), x            limited to +-kLargestValue
//   sine           sin x                   x limited to +-8192
//   gaussian       exp(-x^2)
//   abs            |x|                     limited to kLargestValue
//   step           1 if x > 0, else 0
//
// Largest absolute errors against the exact functions (tests/common/activation_test.cpp): sigmoid, tanh
// 3e-7; gaussian 2e-6; sine 1e-6 for |x| <= 100.
#pragma once

#include <cstdint>

namespace evograsp {

// Values of nodes stay within +-2^64: sums of up to 2^26 links with weights up to 2^20 cannot overflow.
inline constexpr float kLargestValue = 0x1p64f;

// Numbered as proto::Activation is (checked in network.cpp). A plain enum, so that the loops compiled for
// wider machines include no generated code.
enum class Activation : std::uint8_t { kSteepSigmoid, kTanh, kRelu, kLinear, kSine, kGaussian, kAbs, kStep };
inline constexpr int kActivations = 8;

// F is float or a vector of floats (the compilers' vector extension).
namespace activation {

template <class F>
[[gnu::always_inline]] inline F all(float value) {
  return F{} + value;
}
template <class F>
[[gnu::always_inline]] inline F clamp(F x, float low, float high) {
  const F l = all<F>(low), h = all<F>(high);
  x = x < l ? l : x;
  return x > h ? h : x;
}
template <class F>
[[gnu::always_inline]] inline F absolute(F x) {
  const F negated = -x;
  return x < negated ? negated : x;
}
// The nearest whole number, ties to even; |x| < 2^22.
template <class F>
[[gnu::always_inline]] inline F nearest(F x) {
  const F shifted = x + 0x1.8p23f;
  return shifted - 0x1.8p23f;
}

// Rational minimax fit of tanh(x) / x in x^2 on [0, 8.4], relative error 1.1e-8 before rounding.
template <class F>
[[gnu::always_inline]] inline F tanh(F x) {
  x = clamp(x, -8.4f, 8.4f);
  const F z = x * x;
  F p = z * 1.44578e-8f + 2.13797135447e-5f;
  p = p * z + 0.003541613656f;
  p = p * z + 0.134195765302f;
  p = p * z + 0.999999989479f;
  F q = z * 8.21992748011e-7f + 0.000336142115803f;
  q = q * z + 0.0260514251796f;
  q = q * z + 0.467529003566f;
  q = q * z + 1.0f;
  return clamp(x * p / q, -1.0f, 1.0f);
}

template <class F>
[[gnu::always_inline]] inline F steep_sigmoid(F x) {
  const F half = tanh(clamp(x, -8.0f, 8.0f) * 2.45f) * 0.5f;
  return half + 0.5f;
}

// Reduction by multiples of pi in three parts (Cody and Waite), then the Taylor series through r^11.
template <class F>
[[gnu::always_inline]] inline F sine(F x) {
  x = clamp(x, -8192.0f, 8192.0f);
  const F k = nearest(x * 0.318309886f);
  F r = x - k * 3.140625f;
  r = r - k * 9.67502593994140625e-4f;
  r = r - k * 1.509957990978376432e-7f;
  const F half = k * 0.5f;
  const F sign = 1.0f - absolute(half - nearest(half)) * 4.0f;  // odd multiples turn the wave over
  const F z = r * r;
  F p = z * -2.50521084e-8f + 2.75573192e-6f;
  p = p * z + -1.98412698e-4f;
  p = p * z + 8.33333333e-3f;
  p = p * z + -1.66666667e-1f;
  return (r + r * z * p) * sign;
}

// exp(-t) for t = x^2 / 16 <= 1 by a Pade approximant of order (4, 4), then four squarings.
template <class F>
[[gnu::always_inline]] inline F gaussian(F x) {
  x = clamp(x, -4.0f, 4.0f);
  const F t = x * x * 0.0625f;
  const F even = (t * t * 5.95238095e-4f + 1.07142857e-1f) * (t * t) + 1.0f;
  const F odd = (t * t * 1.19047619e-2f + 0.5f) * t;
  F e = (even - odd) / (even + odd);
  e = e * e;
  e = e * e;
  e = e * e;
  return e * e;
}

template <class F>
[[gnu::always_inline]] inline F apply(Activation kind, F x) {
  switch (kind) {
    case Activation::kSteepSigmoid:
      return steep_sigmoid(x);
    case Activation::kTanh:
      return tanh(x);
    case Activation::kRelu:
      return clamp(x, 0.0f, kLargestValue);
    case Activation::kLinear:
      return clamp(x, -kLargestValue, kLargestValue);
    case Activation::kSine:
      return sine(x);
    case Activation::kGaussian:
      return gaussian(x);
    case Activation::kAbs:
      return clamp(absolute(x), 0.0f, kLargestValue);
    case Activation::kStep:
      return x > F{} ? all<F>(1.0f) : F{};
  }
  return x;
}

}  // namespace activation
}  // namespace evograsp

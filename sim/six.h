// Six-vectors, 6x6 inverses and what rounding can hide in them, in double and in quadruple precision.
#pragma once

#include <cmath>
#include <utility>

#include "sim/polytope6.h"

namespace evograsp::sim::six {

// What rounding can hide, for points of length 1.
template <class Real>
struct Tolerance;
template <>
struct Tolerance<double> {
  static constexpr double kGap = 2e-12;   // hull and facet this close are one
  static constexpr double kSeen = 1e-13;  // a point this far beyond a plane sees the facet
  static constexpr double kThin = 1e-10;  // a set thinner than this is flat
};
template <>
struct Tolerance<Quad> {
  static constexpr double kGap = 1e-20;
  static constexpr double kSeen = 1e-24;
  static constexpr double kThin = 1e-13;
};

inline double square_root(double x) {
  return std::sqrt(x);
}

// Newton's iteration from the 53-bit root: two steps give all 113 bits.
inline Quad square_root(Quad x) {
  if (!(x > 0)) return 0;
  Quad y = std::sqrt(static_cast<double>(x));
  if (!(y > 0)) return 0;
  y = (y + x / y) / 2;
  return (y + x / y) / 2;
}

template <class Real>
Real magnitude(Real x) {
  return x < 0 ? -x : x;
}

template <class Point>
auto dot(const Point& a, const Point& b) {
  return ((a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])) + (a[4] * b[4] + a[5] * b[5]);
}

// Replaces m by its inverse: Gauss-Jordan with row pivoting. False when singular to working precision.
template <class Matrix>
bool invert(Matrix& m) {
  using Real = typename Matrix::value_type::value_type;
  Matrix inverse{};
  for (int k = 0; k < 6; ++k) inverse[k][k] = 1;
  for (int k = 0; k < 6; ++k) {
    int pivot = k;
    for (int r = k + 1; r < 6; ++r) {
      if (magnitude(m[r][k]) > magnitude(m[pivot][k])) pivot = r;
    }
    if (!(magnitude(m[pivot][k]) > Tolerance<Real>::kThin * 1e-3)) return false;
    std::swap(m[k], m[pivot]);
    std::swap(inverse[k], inverse[pivot]);
    const Real scale = 1 / m[k][k];
    for (int x = 0; x < 6; ++x) {
      m[k][x] *= scale;
      inverse[k][x] *= scale;
    }
    for (int r = 0; r < 6; ++r) {
      if (r == k) continue;
      const Real factor = m[r][k];
      for (int x = 0; x < 6; ++x) {
        m[r][x] -= factor * m[k][x];
        inverse[r][x] -= factor * inverse[k][x];
      }
    }
  }
  m = inverse;
  return true;
}

}  // namespace evograsp::sim::six

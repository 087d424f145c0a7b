// Support functions of the cores, inlined by kind: the innermost work of every distance query.
#pragma once

#include <cmath>

#include "sim/shape.h"

namespace evograsp::sim {

inline Vec3 support_box(const Vec3& half, const Vec3& d) {
  return {d.x() < 0 ? -half.x() : half.x(), d.y() < 0 ? -half.y() : half.y(),
          d.z() < 0 ? -half.z() : half.z()};
}

inline Vec3 support_disc(const Vec3& half, const Vec3& d) {
  const double z = d.z() < 0 ? -half.z() : half.z();
  const double planar = std::sqrt(d.x() * d.x() + d.y() * d.y());
  if (!(planar > 0)) return {0, 0, z};  // the whole face is extreme: its centre will do
  const double s = half.x() / planar;
  return {s * d.x(), s * d.y(), z};
}

// The first vertex of the greatest dot product: ties are decided by order, on any machine.
inline int extreme_vertex(const Shape& shape, const Vec3& d) {
  const double* x = shape.x.data();
  const double* y = shape.y.data();
  const double* z = shape.z.data();
  const int n = static_cast<int>(shape.x.size());
  int best = 0;
  double most = x[0] * d.x() + y[0] * d.y() + z[0] * d.z();
  for (int i = 1; i < n; ++i) {
    const double dot = x[i] * d.x() + y[i] * d.y() + z[i] * d.z();
    if (dot > most) {
      most = dot;
      best = i;
    }
  }
  return best;
}

inline Vec3 support_hull(const Shape& shape, const Vec3& d) {
  const auto i = static_cast<std::size_t>(extreme_vertex(shape, d));
  return {shape.x[i], shape.y[i], shape.z[i]};
}

template <Core kCore>
Vec3 core_support(const Shape& shape, const Vec3& d) {
  if constexpr (kCore == Core::kPoint) return Vec3::Zero();
  if constexpr (kCore == Core::kSegment) return {0, 0, d.z() < 0 ? -shape.half.z() : shape.half.z()};
  if constexpr (kCore == Core::kBox) return support_box(shape.half, d);
  if constexpr (kCore == Core::kDisc) return support_disc(shape.half, d);
  if constexpr (kCore == Core::kHull) return support_hull(shape, d);
}

}  // namespace evograsp::sim

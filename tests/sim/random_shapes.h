// Random shapes and poses for the tests of the geometry, all from the harness's random streams.
#pragma once

#include <vector>

#include "common/random.h"
#include "sim/shape.h"

namespace evograsp::sim::testing {

inline Vec3 random_vector(Random& random, double half) {
  const double x = random.uniform(-half, half);
  const double y = random.uniform(-half, half);
  const double z = random.uniform(-half, half);
  return {x, y, z};
}

inline Mat3 random_rotation(Random& random) {
  for (;;) {
    const double w = random.uniform(-1, 1);
    const Vec3 v = random_vector(random, 1);
    const double n2 = w * w + v.squaredNorm();
    if (n2 > 1e-2 && n2 <= 1) return rotation_from_quaternion(w, v.x(), v.y(), v.z());
  }
}

inline Pose random_pose(Random& random, double half) {
  const Mat3 rotation = random_rotation(random);
  return {rotation, random_vector(random, half)};
}

// One of the five kinds, at the scale of fingers and household things.
inline Shape random_shape(Random& random, int kind) {
  const double size = random.uniform(0.005, 0.05);
  const double stretch = random.uniform(0.3, 3);
  const double rounding = random.uniform(0.0002, 0.3 * size);
  switch (kind) {
    case 0:
      return Shape::ball(size);
    case 1:
      return Shape::capsule(size, size * stretch);
    case 2:
      return Shape::box({size, size * stretch, size * random.uniform(0.31, 2)},
                        0.9 * rounding * std::min(1.0, stretch));
    case 3:
      return Shape::cylinder(size, size * stretch, 0.9 * rounding * std::min(1.0, stretch));
    default:
      break;
  }
  std::vector<Vec3> vertices;
  const int n = 4 + static_cast<int>(random.below(28));
  for (int i = 0; i < n; ++i) vertices.push_back(random_vector(random, size) + Vec3(0.5 * size, 0, 0));
  return Shape::hull(vertices, rounding);
}

}  // namespace evograsp::sim::testing

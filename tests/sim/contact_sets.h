// Contact sets for tests and benchmarks of grasp quality: random ones and ones made to be awkward.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "common/random.h"
#include "sim/quality.h"

namespace evograsp::sim::testing {

enum class Kind {
  kBlob,     // on a sphere, normals up to 16 degrees off: general position
  kCuboid,   // anywhere on the faces of a cuboid: coplanar contacts, parallel normals
  kCorners,  // at the corners of its faces, often the same corner twice: repeated wrenches
  kCan,      // on three rings of a can, eight directions: many wrenches on one plane
};
inline constexpr Kind kKinds[] = {Kind::kBlob, Kind::kCuboid, Kind::kCorners, Kind::kCan};

inline constexpr double kTorqueScale = 0.05;

inline Vec3 draw_vector(Random& random) {
  Vec3 v;
  for (int x = 0; x < 3; ++x) v[x] = random.uniform(-1, 1);
  return v;
}

inline void place_on_face(Random& random, bool corner, Contact& contact) {
  const int axis = static_cast<int>(random.below(3));
  const double side = random.below(2) == 0 ? 1 : -1;
  Vec3 p = draw_vector(random);
  for (int x = 0; corner && x < 3; ++x) p[x] = p[x] < 0 ? -1 : 1;
  p[axis] = side;
  contact.point = p.cwiseProduct(Vec3(0.03, 0.02, 0.04));
  contact.normal = Vec3::Zero();
  contact.normal[axis] = -side;
}

inline Contact draw_contact(Kind kind, Random& random) {
  Contact contact{};
  contact.mu = 0.5;
  if (kind == Kind::kBlob) {
    const Vec3 out = draw_vector(random).normalized();
    contact.point = 0.04 * out;
    contact.normal = (0.2 * draw_vector(random) - out).normalized();
    contact.mu = random.uniform(0.3, 1.0);
  } else if (kind == Kind::kCan) {
    static constexpr double kHalf = 0.70710678118654752;
    static constexpr double kRing[8][2] = {{1, 0},  {kHalf, kHalf},   {0, 1},  {-kHalf, kHalf},
                                           {-1, 0}, {-kHalf, -kHalf}, {0, -1}, {kHalf, -kHalf}};
    const auto& [x, y] = kRing[random.below(8)];
    const double height = 0.03 * (static_cast<double>(random.below(3)) - 1);
    contact.point = Vec3(0.03 * x, 0.03 * y, height);
    contact.normal = Vec3(-x, -y, 0);
  } else {
    place_on_face(random, kind == Kind::kCorners, contact);
  }
  return contact;
}

inline std::vector<Contact> draw_contacts(Kind kind, int count, std::uint64_t index) {
  Random random(index, Purpose::kTestHarness, static_cast<std::uint64_t>(kind), count);
  std::vector<Contact> contacts;
  for (int i = 0; i < count; ++i) contacts.push_back(draw_contact(kind, random));
  return contacts;
}

inline std::vector<Wrench> draw_wrenches(Kind kind, int contacts, std::uint64_t index) {
  Quality quality;
  const auto w = quality.wrenches(draw_contacts(kind, contacts, index), Vec3::Zero(), kTorqueScale);
  return {w.begin(), w.end()};
}

}  // namespace evograsp::sim::testing

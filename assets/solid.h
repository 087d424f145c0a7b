// Volume, centre and inertia of solids of unit density, and their sums.
#pragma once

#include "common/pose.h"

namespace evograsp::assets {

// A rigid body of density 1: volume in m^3, inertia in m^5 (times a density: kg m^2).
// A hole is a solid taken away: see minus().
struct Solid {
  double volume = 0;
  Vec3 centre = Vec3::Zero();   // body frame
  Mat3 inertia = Mat3::Zero();  // about the centre, body axes

  Solid moved(const Pose& pose) const;
  Solid plus(const Solid& other) const;
  Solid minus(const Solid& other) const;

  // Whether a body of positive density can be so: finite, with a volume, principal moments of inertia
  // positive and none of them more than the other two together. What is flat but for rounding is none.
  bool is_body() const;
};

Solid solid_box(double x, double y, double z);       // full sizes, centred
Solid solid_cylinder(double radius, double height);  // along z, centred
Solid solid_sphere(double radius);

}  // namespace evograsp::assets

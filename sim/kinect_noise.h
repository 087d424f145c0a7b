// What a structured-light depth sensor does to a depth (CameraConfig.noise).
#pragma once

#include "common/random.h"
#include "proto/config.pb.h"
#include "sim/camera.h"

namespace evograsp::sim {

// The reading of a surface at depth `z` (m) with unit normal `normal_W` on `ray`: `far` for a lost one. Axial
// noise is normal with sigma = 0.0012 + axial (z - 0.4)^2 (Nguyen, Izadi, Lovell, 3DIMPVT 2012, eq. 4);
// surfaces at an incidence beyond dropout_angle, and any with chance `dropout`, are lost; quantise rounds to
// eighths of a pixel of disparity over a baseline of 75 mm (Khoshelham and Elberink, Sensors 12, 2012).
// Always draws three numbers, whatever happens.
double noisy_depth(const proto::KinectNoise& noise, const Camera& camera, const Ray& ray,
                   const Vec3& normal_W, double z, Random& random);
// A ray without return draws the same numbers.
double noisy_nothing(Random& random, double far_m);

// Standard normal by Box and Muller (1958), with reproducible functions. Draws two numbers.
double draw_normal(Random& random);

}  // namespace evograsp::sim

// Objects made by hand for the tests of the scene and the camera.
#pragma once

#include <cmath>
#include <string>

#include "common/det_math.h"
#include "common/pose.h"
#include "common/random.h"
#include "proto/bundle.pb.h"
#include "proto/wire.pb.h"

namespace evograsp::sim::testing {

inline proto::ObjectBundle named(const std::string& name, double height, double footprint) {
  proto::ObjectBundle object;
  object.set_name(name);
  object.set_mass(0.2);
  *object.mutable_centre_of_mass() = to_proto(Vec3(0, 0, 0));
  object.add_resting()->set_height(height);
  object.set_footprint_radius(footprint);
  object.set_torque_scale(footprint);
  return object;
}

inline proto::ObjectBundle box(double hx, double hy, double hz) {
  proto::ObjectBundle object = named("box", hz, std::sqrt(hx * hx + hy * hy));
  proto::ConvexPart::Box* shape = object.add_part()->mutable_box();
  shape->set_hx(hx), shape->set_hy(hy), shape->set_hz(hz);
  return object;
}

inline proto::ObjectBundle ball(double radius) {
  proto::ObjectBundle object = named("ball", radius, radius);
  object.add_part()->mutable_ball()->set_radius(radius);
  return object;
}

inline proto::ObjectBundle cylinder(double radius, double half_length) {
  proto::ObjectBundle object = named("cylinder", half_length, radius);
  proto::ConvexPart::Rod* shape = object.add_part()->mutable_cylinder();
  shape->set_radius(radius), shape->set_half_length(half_length);
  return object;
}

inline proto::ObjectBundle capsule(double radius, double half_length) {
  proto::ObjectBundle object = named("capsule", half_length + radius, radius);
  proto::ConvexPart::Rod* shape = object.add_part()->mutable_capsule();
  shape->set_radius(radius), shape->set_half_length(half_length);
  return object;
}

// The same box as a hull of its eight corners.
inline proto::ObjectBundle hull_box(double hx, double hy, double hz) {
  proto::ObjectBundle object = named("hull", hz, std::sqrt(hx * hx + hy * hy));
  proto::ConvexPart::Hull* shape = object.add_part()->mutable_hull();
  for (const double x : {-hx, hx})
    for (const double y : {-hy, hy})
      for (const double z : {-hz, hz}) shape->add_xyz(x), shape->add_xyz(y), shape->add_xyz(z);
  return object;
}

// A sphere of 2 x rings x segments triangles with a rippled surface, as the visual mesh of a ball.
inline proto::ObjectBundle rippled(double radius, int rings, int segments) {
  proto::ObjectBundle object = ball(radius * 1.1);
  object.set_name("rippled");
  proto::TriangleMesh* mesh = object.mutable_visual();
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < segments; ++j) {
      const double theta = 3.14159265358979 * i / rings, phi = 2 * 3.14159265358979 * j / segments;
      const double r = radius * (1 + 0.1 * det::sin(9 * theta) * det::cos(7 * phi));
      const double across = i == 0 || i == rings ? 0 : r * det::sin(theta);  // the poles are one point each
      mesh->add_xyz(static_cast<float>(across * det::cos(phi)));
      mesh->add_xyz(static_cast<float>(across * det::sin(phi)));
      mesh->add_xyz(static_cast<float>(r * det::cos(theta)));
    }
  const auto vertex = [&](int i, int j) { return static_cast<std::uint32_t>(i * segments + j % segments); };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < segments; ++j) {
      for (const std::uint32_t v : {vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)})
        mesh->add_triangle(v);
      for (const std::uint32_t v : {vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)})
        mesh->add_triangle(v);
    }
  return object;
}

// Every default of the schema.
inline proto::Experiment experiment() {
  proto::Experiment out;
  out.mutable_scene(), out.mutable_camera(), out.mutable_grasp(), out.mutable_trials();
  return out;
}

inline Vec3 random_vector(Random& random, double size) {
  const double x = random.uniform(-size, size), y = random.uniform(-size, size),
               z = random.uniform(-size, size);
  return {x, y, z};
}

}  // namespace evograsp::sim::testing

#include "assets/parts.h"
#include "assets/shape.h"

namespace evograsp::assets {

Shape cylinder_shape(const proto::CylinderShape& shape) {
  return {{cylinder_part({}, shape.radius(), shape.height() / 2)},
          {},
          solid_cylinder(shape.radius(), shape.height()),
          {}};
}

Shape cuboid_shape(const proto::CuboidShape& shape) {
  return {{box_part({}, Vec3(shape.x(), shape.y(), shape.z()) / 2)},
          {},
          solid_box(shape.x(), shape.y(), shape.z()),
          {}};
}

Shape sphere_shape(const proto::SphereShape& shape) {
  return {{ball_part(Vec3::Zero(), shape.radius())}, {}, solid_sphere(shape.radius()), {}};
}

}  // namespace evograsp::assets

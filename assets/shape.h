// What an object file's shape becomes before masses and resting poses: convex parts, what a camera sees, and
// the solid it fills.
#pragma once

#include <string>
#include <vector>

#include "assets/solid.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "proto/object.pb.h"

namespace evograsp::assets {

struct Shape {
  std::vector<proto::ConvexPart> parts;
  proto::TriangleMesh visual;  // empty: the parts themselves are seen
  Solid solid;
  std::vector<std::string> warnings;
};

Shape cylinder_shape(const proto::CylinderShape& shape);
Shape cuboid_shape(const proto::CuboidShape& shape);
Shape sphere_shape(const proto::SphereShape& shape);

// The cup as 12 wall wedges, a floor and 6 handle capsules, so that fingers enter cup and handle. The wedges'
// flat insides straddle the true inner wall: at most 0.9 % of the inner radius off either way. Errors: sizes
// that leave no wall, no cavity or no handle hole.
Result<Shape> mug_shape(const proto::MugShape& shape);
// The mug standing fixed on a flat round plate; the frame stays the mug's.
Result<Shape> plated_mug_shape(const proto::PlatedMugShape& shape);

}  // namespace evograsp::assets

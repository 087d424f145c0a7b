#include "sim/lift_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace evograsp::sim {
namespace {

// Sharper edges than this make Bullet's contacts jump.
constexpr double kMinMargin = 0.0005;

}  // namespace

btVector3 to_bullet(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
btMatrix3x3 to_bullet(const Mat3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}
btTransform to_bullet(const Pose& pose) {
  return btTransform(to_bullet(pose.rotation), to_bullet(pose.position));
}
btQuaternion quaternion(const Mat3& rotation) {
  const Eigen::Quaterniond q(rotation);
  return {q.x(), q.y(), q.z(), q.w()};
}
Vec3 from_bullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
Pose from_bullet(const btTransform& transform) {
  Pose pose;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.rotation(r, c) = transform.getBasis()[r][c];
  }
  pose.position = from_bullet(transform.getOrigin());
  return pose;
}

template <class Shape>
Shape* LiftShapes::keep(std::unique_ptr<Shape> shape) {
  Shape* const kept = shape.get();
  shapes_.push_back(std::move(shape));
  return kept;
}

btCollisionShape* LiftShapes::box(const Vec3& half) {
  return keep(std::make_unique<btBoxShape>(to_bullet(half)));
}

btCollisionShape* LiftShapes::convex(const proto::ConvexPart& part) {
  const double margin = std::max(part.rounding(), kMinMargin);
  switch (part.shape_case()) {
    case proto::ConvexPart::kBox: {
      auto* box =
          keep(std::make_unique<btBoxShape>(btVector3(part.box().hx(), part.box().hy(), part.box().hz())));
      box->setMargin(margin);
      return box;
    }
    case proto::ConvexPart::kBall:
      return keep(std::make_unique<btSphereShape>(part.ball().radius()));
    case proto::ConvexPart::kCylinder: {
      const auto& rod = part.cylinder();
      auto* cylinder =
          keep(std::make_unique<btCylinderShapeZ>(btVector3(rod.radius(), rod.radius(), rod.half_length())));
      cylinder->setMargin(margin);
      return cylinder;
    }
    case proto::ConvexPart::kCapsule:
      return keep(
          std::make_unique<btCapsuleShapeZ>(part.capsule().radius(), 2 * part.capsule().half_length()));
    case proto::ConvexPart::kHull: {
      auto* hull = keep(std::make_unique<btConvexHullShape>());
      const auto& xyz = part.hull().xyz();
      for (int i = 0; i + 2 < xyz.size(); i += 3)
        hull->addPoint(btVector3(xyz[i], xyz[i + 1], xyz[i + 2]), false);
      hull->recalcLocalAabb();
      hull->setMargin(margin);
      return hull;
    }
    case proto::ConvexPart::SHAPE_NOT_SET:
      break;
  }
  return keep(std::make_unique<btEmptyShape>());
}

btCollisionShape* LiftShapes::body(const google::protobuf::RepeatedPtrField<proto::ConvexPart>& parts,
                                   const Pose& frame) {
  auto* compound = keep(std::make_unique<btCompoundShape>());
  const Pose into = frame.inverse();
  for (const proto::ConvexPart& part : parts) {
    compound->addChildShape(to_bullet(into * from_proto(part.pose())), convex(part));
  }
  return compound;
}

}  // namespace evograsp::sim

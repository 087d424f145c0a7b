// Bundles as Bullet shapes. Internal to the lift test.
#pragma once

#include <btBulletCollisionCommon.h>

#include <memory>
#include <vector>

#include "common/pose.h"
#include "proto/bundle.pb.h"

namespace evograsp::sim {

btVector3 to_bullet(const Vec3& v);
btMatrix3x3 to_bullet(const Mat3& m);
btTransform to_bullet(const Pose& pose);
btQuaternion quaternion(const Mat3& rotation);
Vec3 from_bullet(const btVector3& v);
Pose from_bullet(const btTransform& transform);

// Owns shapes, which Bullet only points at.
class LiftShapes {
 public:
  // The parts of one body, given in the body's frame, as seen from `frame` in it (the centre of mass).
  btCollisionShape* body(const google::protobuf::RepeatedPtrField<proto::ConvexPart>& parts,
                         const Pose& frame);
  btCollisionShape* box(const Vec3& half);

 private:
  btCollisionShape* convex(const proto::ConvexPart& part);
  template <class Shape>
  Shape* keep(std::unique_ptr<Shape> shape);

  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
};

}  // namespace evograsp::sim

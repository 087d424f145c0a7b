#include "sim/lift_world.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/lift_libm.h"
#include "sim/lift_shapes.h"
#include "sim/shape.h"

namespace evograsp::sim {
namespace {

constexpr int kSolverIterations = 50;
constexpr double kTableHalf = 0.5, kTableThickness = 0.05;  // m
constexpr double kLeastLinkMass = 0.01;                     // kg, for links whose file names none
// kg m^2: what a geared motor's rotor adds to a joint (1e-7 through 70 to 1). Without it a fingertip's own
// 1e-5 meets torques that would spin it up by 200 rad/s in a step, and the solver cannot balance those with
// contacts.
constexpr double kRotorInertia = 5e-4;
constexpr double kLockedTorque = 50;  // N m: a joint that no motor moves
constexpr double kStiffness = 0.2;    // of the remaining error, taken back in one step

enum Group { kTable = 1, kObject = 2, kHand = 4 };

// The frame of the principal axes of inertia at the centre of mass, and the moments about them.
struct Principal {
  Pose frame;
  Vec3 moments;
};
Principal principal_frame(const proto::ObjectBundle& object) {
  Mat3 inertia;
  const auto& i = object.inertia();
  inertia << i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2];
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
  Principal p;
  p.frame.rotation = solver.eigenvectors();
  if (p.frame.rotation.determinant() < 0) p.frame.rotation.col(0) *= -1;
  p.frame.position = from_proto(object.centre_of_mass());
  p.moments = solver.eigenvalues().cwiseMax(1e-9);
  return p;
}

// A motor of a joint; once it holds, it only pushes towards closed: what opens the joint it resists, what
// closes it further it lets be.
class ClosingMotor : public btMultiBodyJointMotor {
 public:
  ClosingMotor(btMultiBody* body, int joint, double velocity, double impulse)
      : btMultiBodyJointMotor(body, joint, velocity, impulse), forward_(velocity > 0) {}

  void hold(double position, double impulse) {
    holds_ = true;
    setVelocityTarget(0);
    setPositionTarget(position, kStiffness);
    setMaxAppliedImpulse(impulse);
  }

  void createConstraintRows(btMultiBodyConstraintArray& rows, btMultiBodyJacobianData& data,
                            const btContactSolverInfo& info) override {
    const int first = rows.size();
    btMultiBodyJointMotor::createConstraintRows(rows, data, info);
    for (int i = first; holds_ && i < rows.size(); ++i) {
      (forward_ ? rows[i].m_lowerLimit : rows[i].m_upperLimit) = 0;
    }
  }

 private:
  bool forward_;
  bool holds_ = false;
};

bool moves(const proto::HandBundle::Motor& motor, int joint) {
  return std::find(motor.joint().begin(), motor.joint().end(), joint) != motor.joint().end();
}

// How far the link beyond a joint, and what the same motor moves beyond that, reaches when straight.
double lever(const proto::HandBundle& hand, const proto::HandBundle::Motor& motor, int joint) {
  double reach = 0;
  for (const auto& part : hand.link(joint + 1).part()) {
    if (const auto shape = Shape::from_proto(part)) {
      reach = std::max(reach, (from_proto(part.pose()) * shape->centre).norm() + shape->radius);
    }
  }
  for (int next = joint + 1; next < hand.joint_size(); ++next) {
    const auto& child = hand.joint(next);
    if (static_cast<int>(child.parent_link()) != joint + 1 || !moves(motor, next)) continue;
    reach = std::max(reach, from_proto(child.origin()).position.norm() + lever(hand, motor, next));
  }
  return reach;
}

// The lever of a joint as a part of that of its finger's first joint.
double lever_share(const proto::HandBundle& hand, const proto::HandBundle::Motor& motor, int joint) {
  int first = joint;
  while (hand.joint(first).parent_link() > 0 &&
         moves(motor, static_cast<int>(hand.joint(first).parent_link()) - 1)) {
    first = static_cast<int>(hand.joint(first).parent_link()) - 1;
  }
  const double whole = lever(hand, motor, first);
  return whole > 0 ? lever(hand, motor, joint) / whole : 1;
}

}  // namespace

// Members die in reverse order: the world first, then what it points at.
struct LiftWorld::Parts {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  LiftShapes shapes;
  btDefaultMotionState table_state;
  std::unique_ptr<btRigidBody> table, object;
  std::unique_ptr<btMultiBody> hand;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
  std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints;
  // A joint that a motor closes.
  struct Driven {
    int joint;
    double torque;  // towards closed, signed
    double speed;   // when nothing is in the way
    ClosingMotor* row;
  };
  std::vector<Driven> driven;
  bool squeezing = false;
  btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  double step_s = 0, gravity = 0;

  void add_table(double mu);
  void add_object(const proto::ObjectBundle& bundle, const Pose& pose);
  void add_hand(const LiftSetup& setup);
  void add_joint(const proto::HandBundle& bundle, int index);
  void add_collider(const proto::HandBundle& bundle, int link, double mu);
  void add_motors(const proto::HandBundle& bundle, std::span<const double> start);
  void hold(int joint, double value, double torque);
};

void LiftWorld::Parts::add_table(double mu) {
  table_state =
      btDefaultMotionState(btTransform(btQuaternion::getIdentity(), btVector3(0, 0, -kTableThickness)));
  auto* shape = shapes.box(Vec3(kTableHalf, kTableHalf, kTableThickness));
  table = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0, &table_state, shape));
  table->setFriction(mu);
  table->setCollisionFlags(table->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  table->setActivationState(DISABLE_DEACTIVATION);
  world.addRigidBody(table.get(), kTable, kObject | kHand);
}

void LiftWorld::Parts::add_object(const proto::ObjectBundle& bundle, const Pose& pose) {
  const Principal principal = principal_frame(bundle);
  auto* shape = shapes.body(bundle.part(), principal.frame);
  btRigidBody::btRigidBodyConstructionInfo info(bundle.mass(), nullptr, shape, to_bullet(principal.moments));
  info.m_startWorldTransform = to_bullet(pose * principal.frame);
  object = std::make_unique<btRigidBody>(info);
  // Bullet multiplies the frictions of a pair: the object's is 1, so that the others' are those of the pairs.
  object->setFriction(1);
  object->setActivationState(DISABLE_DEACTIVATION);
  world.addRigidBody(object.get(), kObject, kTable | kHand);
}

void LiftWorld::Parts::add_joint(const proto::HandBundle& bundle, int index) {
  const auto& joint = bundle.joint(index);
  const auto& link = bundle.link(index + 1);
  const int parent = static_cast<int>(joint.parent_link());
  const Pose origin = from_proto(joint.origin());
  const Vec3 parent_centre = parent == 0 ? Vec3::Zero() : from_proto(bundle.link(parent).centre_of_mass());
  const double mass = std::max(link.mass(), kLeastLinkMass);
  btVector3 inertia;
  shapes.body(link.part(), Pose{Mat3::Identity(), from_proto(link.centre_of_mass())})
      ->calculateLocalInertia(mass, inertia);
  inertia += btVector3(1, 1, 1) * kRotorInertia;
  const btQuaternion to_link = quaternion(origin.rotation.transpose());
  const btVector3 pivot = to_bullet(Vec3(origin.position - parent_centre));
  const btVector3 centre = to_bullet(from_proto(link.centre_of_mass()));
  const btVector3 axis = to_bullet(from_proto(joint.axis()));
  if (joint.prismatic()) {
    hand->setupPrismatic(index, mass, inertia, parent - 1, to_link, axis, pivot, centre, true);
  } else {
    hand->setupRevolute(index, mass, inertia, parent - 1, to_link, axis, pivot, centre, true);
  }
}

void LiftWorld::Parts::add_collider(const proto::HandBundle& bundle, int link, double mu) {
  auto collider = std::make_unique<btMultiBodyLinkCollider>(hand.get(), link - 1);
  Pose frame;
  if (link > 0) frame.position = from_proto(bundle.link(link).centre_of_mass());
  collider->setCollisionShape(shapes.body(bundle.link(link).part(), frame));
  collider->setFriction(mu);
  if (link == 0) {
    hand->setBaseCollider(collider.get());
  } else {
    hand->getLink(link - 1).m_collider = collider.get();
  }
  world.addCollisionObject(collider.get(), kHand, link == 0 ? kObject : kObject | kTable);
  colliders.push_back(std::move(collider));
}

void LiftWorld::Parts::hold(int joint, double value, double torque) {
  auto motor = std::make_unique<btMultiBodyJointMotor>(hand.get(), joint, 0, torque * step_s);
  motor->setPositionTarget(value, kStiffness);
  world.addMultiBodyConstraint(motor.get());
  constraints.push_back(std::move(motor));
}

// A joint that closes turns at its share of the motor's speed until it meets what its share of the torque
// cannot move: by virtual work a joint of ratio r has 1 / r of the motor's torque.
void LiftWorld::Parts::add_motors(const proto::HandBundle& bundle, std::span<const double> start) {
  std::vector<std::uint8_t> moved(bundle.joint_size(), 0);
  for (const auto& motor : bundle.motor()) {
    for (int k = 0; k < motor.joint_size(); ++k) {
      const int j = static_cast<int>(motor.joint(k));
      const double ratio = motor.ratio(k);
      if (bundle.joint(j).locked() || ratio == 0) continue;
      moved[j] = 1;
      if (motor.hold()) {
        hold(j, start[j], motor.max_torque());
        continue;
      }
      const double torque = motor.max_torque() * lever_share(bundle, motor, j);
      auto row = std::make_unique<ClosingMotor>(hand.get(), j, motor.speed() * ratio, torque * step_s);
      world.addMultiBodyConstraint(row.get());
      driven.push_back({j, std::copysign(torque, ratio), motor.speed() * std::fabs(ratio), row.get()});
      constraints.push_back(std::move(row));
    }
  }
  for (int j = 0; j < bundle.joint_size(); ++j) {
    if (moved[j] == 0) hold(j, start[j], kLockedTorque);
    auto limit = std::make_unique<btMultiBodyJointLimitConstraint>(hand.get(), j, bundle.joint(j).lower(),
                                                                   bundle.joint(j).upper());
    world.addMultiBodyConstraint(limit.get());
    constraints.push_back(std::move(limit));
  }
}

void LiftWorld::Parts::add_hand(const LiftSetup& setup) {
  const proto::HandBundle& bundle = *setup.hand;
  hand = std::make_unique<btMultiBody>(bundle.joint_size(), 0, btVector3(0, 0, 0), true, false);
  hand->setBasePos(to_bullet(setup.palm.position));
  hand->setWorldToBaseRot(quaternion(setup.palm.rotation.transpose()));
  hand->setHasSelfCollision(false);
  for (int j = 0; j < bundle.joint_size(); ++j) add_joint(bundle, j);
  hand->finalizeMultiDof();
  for (int j = 0; j < bundle.joint_size(); ++j) hand->setJointPos(j, setup.joints[j]);
  world.addMultiBody(hand.get());
  for (int l = 0; l < bundle.link_size(); ++l) add_collider(bundle, l, setup.mu[l]);
  add_motors(bundle, setup.joints);
  btAlignedObjectArray<btQuaternion> rotations;
  btAlignedObjectArray<btVector3> origins;
  hand->forwardKinematics(rotations, origins);
  hand->updateCollisionObjectWorldTransforms(rotations, origins);
}

LiftWorld::LiftWorld(const LiftSetup& setup, const LiftOptions& options) : parts_(std::make_unique<Parts>()) {
  keep_own_libm();
  Parts& p = *parts_;
  p.step_s = options.step_s;
  p.gravity = options.gravity;
  p.world.getSolverInfo().m_numIterations = kSolverIterations;
  p.world.getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
  p.world.setGravity(btVector3(0, 0, -options.gravity));
  p.add_table(setup.table_mu);
  p.add_object(*setup.object, setup.object_pose);
  p.add_hand(setup);
}

LiftWorld::~LiftWorld() = default;

void LiftWorld::step(const Vec3& acceleration, double table_speed) {
  Parts& p = *parts_;
  p.world.setGravity(to_bullet(Vec3(Vec3(0, 0, -p.gravity) - acceleration)));
  btTransform table;
  p.table_state.getWorldTransform(table);
  table.getOrigin() -= btVector3(0, 0, table_speed * p.step_s);
  p.table_state.setWorldTransform(table);
  if (p.squeezing) {
    for (const auto& driven : p.driven) p.hand->addJointTorque(driven.joint, driven.torque / 2);
  }
  p.world.stepSimulation(p.step_s, 0);
}

void LiftWorld::hold_closed() {
  Parts& p = *parts_;
  p.squeezing = true;
  for (const auto& driven : p.driven) {
    driven.row->hold(p.hand->getJointPos(driven.joint), std::fabs(driven.torque) / 2 * p.step_s);
  }
}

void LiftWorld::remove_table() {
  parts_->world.removeRigidBody(parts_->table.get());
}

Pose LiftWorld::object() const {
  return from_bullet(parts_->object->getWorldTransform());
}

bool LiftWorld::touches_hand() const {
  const Parts& p = *parts_;
  for (int i = 0; i < p.dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold* m = const_cast<Parts&>(p).dispatcher.getManifoldByIndexInternal(i);
    const bool object = m->getBody0() == p.object.get() || m->getBody1() == p.object.get();
    const bool table = m->getBody0() == p.table.get() || m->getBody1() == p.table.get();
    if (!object || table) continue;
    for (int k = 0; k < m->getNumContacts(); ++k) {
      if (m->getContactPoint(k).getAppliedImpulse() > 0) return true;
    }
  }
  return false;
}

double LiftWorld::joint(int index) const {
  return parts_->hand->getJointPos(index);
}

double LiftWorld::fastest_joint() const {
  double fastest = 0;
  for (const auto& driven : parts_->driven) {
    fastest = std::max(fastest, std::fabs(parts_->hand->getJointVel(driven.joint)) / driven.speed);
  }
  return fastest;
}

}  // namespace evograsp::sim

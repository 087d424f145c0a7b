#include "sim/closing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace evograsp::sim {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kNotPosed = -1;
constexpr double kAim = 0.9;          // steps aim at this part of the tolerance
constexpr int kMaxEvents = 100000;    // per motor: far beyond need; a hand that gets there stays where it is
constexpr double kMovingAway = 1e-3;  // part of the speed bound: slower than this along n counts as resting
constexpr double kSmallestStep = 1e-9;  // of a motor's travel

template <class T>
T& at(std::vector<T>& v, int i) {
  return v[static_cast<std::size_t>(i)];
}

// Smallest s > 0 at which room - v s - a s^2 / 2 = 0.
double exhausted(double room, double v, double a) {
  const double root = std::sqrt(v * v + 2 * a * room);
  if (v > 0) return 2 * room / (v + root);
  return a > 0 ? (root - v) / a : kNever;
}

}  // namespace

Closing::Closing(const HandModel& hand, int obstacles)
    : start_(hand.joints().size()),
      stop_(hand.joints().size()),
      link_at_(static_cast<std::size_t>(hand.link_count())),
      part_at_(hand.parts().size()),
      motion_(hand.parts().size()) {
  std::size_t most = 0;
  for (const HandMotor& motor : hand.motors())
    most = std::max(most, motor.part.size() * (static_cast<std::size_t>(obstacles) + hand.parts().size()));
  pairs_.reserve(std::min<std::size_t>(most, 4096));
}

void Closing::close(const HandModel& hand, const PosedWorld& world, double tolerance, HandState& state) {
  hand_ = &hand;
  world_ = &world;
  state_ = &state;
  tolerance_ = tolerance;
  queries_ = 0;
  for (const HandMotor& motor : hand.motors()) {
    motor_ = &motor;
    std::fill(link_at_.begin(), link_at_.end(), kNever);  // links that stand still are posed for ever
    std::fill(part_at_.begin(), part_at_.end(), kNever);
    for (int l : motor.link) at(link_at_, l) = kNotPosed;
    for (int p : motor.part) at(part_at_, p) = kNotPosed;
    active_ = 0;
    for (int j : motor.joint) {
      const HandJoint& joint = hand.joints()[static_cast<std::size_t>(j)];
      const double ratio = hand.ratio(j), q = at(state.value, j);
      at(start_, j) = q;
      at(stop_, j) = std::max(0.0, ((ratio > 0 ? joint.upper : joint.lower) - q) / ratio);
      if (at(stop_, j) > 0) active_ |= JointSet{1} << j;
    }
    refresh_motion(motor.joints);
    gather(motor);
    advance();
    for (int j : motor.joint) {
      const HandJoint& joint = hand.joints()[static_cast<std::size_t>(j)];
      at(state.value, j) = std::clamp(at(start_, j) + hand.ratio(j) * at(stop_, j), joint.lower, joint.upper);
    }
    for (int p : motor.part) pose_part(p, kNever);
  }
}

void Closing::refresh_motion(JointSet changed) {
  for (int p : motor_->part) {
    const JointSet above = hand_->ancestors(hand_->parts()[static_cast<std::size_t>(p)].link);
    if (!(above & changed)) continue;
    PartMotion& m = at(motion_, p);
    m.active = above & active_;
    m.bound = hand_->motion_bound(p, m.active);
    m.end = 0;
    for (JointSet rest = m.active; rest != 0; rest &= rest - 1)
      m.end = std::max(m.end, at(stop_, __builtin_ctzll(rest)));
  }
}

// Pairs that the motor could bring together: within the reach of its innermost joint and, for a finger that
// curls in a plane, not beside it.
void Closing::gather(const HandMotor& motor) {
  pairs_.clear();
  for (std::size_t i = 0; i < motor.part.size(); ++i) {
    const int p = motor.part[i];
    const PartMotion& motion = at(motion_, p);
    if (motion.active == 0) continue;
    pose_part(p, 0);
    const int j = __builtin_ctzll(motion.active);
    const Pose& hinge = at(state_->link, j + 1);
    const double reach = hand_->reach(j, p) + tolerance_, reach2 = reach * reach;
    const Vec3 axis = hinge.rotation * hand_->joints()[static_cast<std::size_t>(j)].axis;
    const double slab_lo = lowest(p, axis) - tolerance_, slab_hi = -lowest(p, -axis) + tolerance_;
    const bool planar = motor.planar[i] != 0;
    const auto consider = [&](const Obstacle& o) {
      if (o.box.squared_distance(hinge.position) > reach2) return;
      const Vec3 centre = 0.5 * (o.box.lo + o.box.hi);
      if (planar) {
        const double middle = axis.dot(centre);
        const double half = 0.5 * axis.cwiseAbs().dot(o.box.hi - o.box.lo);
        if (middle - half > slab_hi || middle + half < slab_lo) return;
      }
      add_pair(p, &o, *o.shape, o.pose, centre);
    };
    consider(world_->obstacle[0]);
    for (const PosedWorld::Body& body : world_->body) {
      if (!body.present || body.box.squared_distance(hinge.position) > reach2) continue;
      for (int k = 0; k < body.count; ++k)
        consider(world_->obstacle[static_cast<std::size_t>(body.first) + static_cast<std::size_t>(k)]);
    }
    for (std::size_t k = 0; k < hand_->parts().size(); ++k) {
      const HandPart& other = hand_->parts()[k];
      if ((hand_->ancestors(other.link) & motor.joints) || !hand_->may_collide(p, static_cast<int>(k)))
        continue;
      const Pose& pose = state_->part[k];
      const Vec3 centre = pose * other.shape.centre;
      const double r = other.shape.radius + reach;
      if ((centre - hinge.position).squaredNorm() > r * r) continue;
      if (planar) {
        const Vec3 along = pose.rotation.transpose() * axis;
        if (axis.dot(pose * other.shape.support(-along)) - other.shape.sweep > slab_hi ||
            axis.dot(pose * other.shape.support(along)) + other.shape.sweep < slab_lo)
          continue;
      }
      add_pair(p, nullptr, other.shape, pose, centre);
    }
  }
}

void Closing::add_pair(int part, const Obstacle* obstacle, const Shape& shape, const Pose& pose,
                       const Vec3& centre) {
  Pair pair;
  pair.shape = &shape;
  pair.pose = &pose;
  pair.obstacle = obstacle;
  pair.part = part;
  pair.at = 0;
  const Vec3 between =
      at(state_->part, part) * hand_->parts()[static_cast<std::size_t>(part)].shape.centre - centre;
  const bool table = obstacle != nullptr && obstacle->object == kTableObject;
  const double length = between.norm();
  pair.normal = table || !(length > 0) ? Vec3::UnitZ() : Vec3(between / length);
  const Vec3 top = pose * shape.support(pose.rotation.transpose() * pair.normal);
  pair.obstacle_top = pair.normal.dot(top) + shape.sweep;
  pair.gap = 0;
  if (!renew_by_direction(pair, 0)) pair.due = 0;
  if (!out_of_reach(pair)) pairs_.push_back(pair);
}

void Closing::advance() {
  for (int event = 0; active_ != 0; ++event) {
    double limit = kNever;
    for (JointSet rest = active_; rest != 0; rest &= rest - 1)
      limit = std::min(limit, at(stop_, __builtin_ctzll(rest)));
    std::size_t next = pairs_.size();
    double due = limit;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (pairs_[i].due < due) {
        due = pairs_[i].due;
        next = i;
      }
    }
    if (event >= kMaxEvents) {
      stop(active_, due);
    } else if (next == pairs_.size()) {
      if (pairs_.empty()) return;  // nothing in the way: every joint reaches its limit
      JointSet at_limit = 0;
      for (JointSet rest = active_; rest != 0; rest &= rest - 1)
        if (at(stop_, __builtin_ctzll(rest)) <= limit) at_limit |= rest & -rest;
      stop(at_limit, limit);
    } else {
      Pair& pair = pairs_[next];
      pose_part(pair.part, due);
      if (!renew_by_direction(pair, due) && renew_by_distance(pair, due)) {
        stop(at(motion_, pair.part).active, due);
      } else if (out_of_reach(pair)) {
        pair = pairs_.back();
        pairs_.pop_back();
      }
    }
  }
}

// Joints stop at travel s: what they carried moves otherwise now, so the proofs of these pairs are renewed
// from what is left of their gaps.
void Closing::stop(JointSet joints, double s) {
  for (JointSet rest = joints; rest != 0; rest &= rest - 1) {
    const int j = __builtin_ctzll(rest);
    at(stop_, j) = std::min(at(stop_, j), s);
  }
  active_ &= ~joints;
  for (std::size_t i = 0; i < pairs_.size();) {
    Pair& pair = pairs_[i];
    const PartMotion& old = at(motion_, pair.part);
    if (!(old.active & joints)) {
      ++i;
      continue;
    }
    if (!(old.active & active_)) {
      pair = pairs_.back();
      pairs_.pop_back();
      continue;
    }
    const double moved = s - pair.at;
    const double left = std::max(pair.gap - pair.speed * moved - 0.5 * pair.acceleration * moved * moved,
                                 pair.gap - old.bound.speed * moved);
    const HandModel::MotionBound bound = hand_->motion_bound(pair.part, old.active & active_);
    pair.gap = left;
    pair.speed = bound.speed;
    pair.acceleration = 0;
    pair.at = s;
    pair.due = s + std::max(0.0, left - kAim * tolerance_) / bound.speed;
    ++i;
  }
  refresh_motion(joints);
}

void Closing::pose_link(int link, double s) {
  if (!(at(link_at_, link) != s) || at(link_at_, link) == kNever) return;
  const int j = link - 1;
  const HandJoint& joint = hand_->joints()[static_cast<std::size_t>(j)];
  pose_link(joint.parent_link, s);
  double q = at(state_->value, j);
  if (motor_->joints >> j & 1)
    q = std::clamp(at(start_, j) + hand_->ratio(j) * std::min(s, at(stop_, j)), joint.lower, joint.upper);
  at(state_->link, link) = joint.child(at(state_->link, joint.parent_link), q);
  at(link_at_, link) = s;
}

void Closing::pose_part(int part, double s) {
  if (at(part_at_, part) == s) return;
  const HandPart& p = hand_->parts()[static_cast<std::size_t>(part)];
  pose_link(p.link, s);
  at(state_->part, part) = at(state_->link, p.link) * p.pose;
  at(part_at_, part) = s;
}

double Closing::lowest(int part, const Vec3& normal) const {
  const Shape& shape = hand_->parts()[static_cast<std::size_t>(part)].shape;
  const Pose& pose = state_->part[static_cast<std::size_t>(part)];
  return normal.dot(pose * shape.support(-(pose.rotation.transpose() * normal))) -
         shape.sweep * normal.norm();
}

// How fast the part closes along -normal per unit of travel: of one point, or the most of any of its points.
// A point x moves with W x + u; along -n that is (W x n) . x - n . u, again a support function.
double Closing::speed_along(int part, const Vec3& normal, const Vec3* point) const {
  Vec3 turning = Vec3::Zero(), shift = Vec3::Zero();
  for (JointSet rest = motion_[static_cast<std::size_t>(part)].active; rest != 0; rest &= rest - 1) {
    const auto j = static_cast<std::size_t>(__builtin_ctzll(rest));
    const Pose& child = state_->link[j + 1];
    const Vec3 axis = hand_->ratio(static_cast<int>(j)) * (child.rotation * hand_->joints()[j].axis);
    if (hand_->joints()[j].prismatic) {
      shift += axis;
    } else {
      turning += axis;
      shift -= axis.cross(child.position);
    }
  }
  const Vec3 slope = turning.cross(normal);
  const double constant = -normal.dot(shift);
  return constant + (point != nullptr ? slope.dot(*point) : -lowest(part, -slope));
}

void Closing::set_due(Pair& pair, double s, double room) {
  const PartMotion& motion = at(motion_, pair.part);
  pair.at = s;
  pair.due = s + std::max(exhausted(room, pair.speed, pair.acceleration), room / motion.bound.speed);
}

// Whether the part can never come near again, whichever of its joints stop on the way: only then may a pair
// be forgotten, since `due` holds for the joints that move now.
bool Closing::out_of_reach(const Pair& pair) const {
  const PartMotion& motion = motion_[static_cast<std::size_t>(pair.part)];
  return pair.gap - motion.bound.speed * (motion.end - pair.at) > tolerance_;
}

// Renews the proof with the direction at hand: one or two support functions instead of a distance. False when
// the direction shows too little.
bool Closing::renew_by_direction(Pair& pair, double s) {
  const double gap = lowest(pair.part, pair.normal) - pair.obstacle_top;
  if (!(gap > tolerance_)) return false;
  const PartMotion& motion = at(motion_, pair.part);
  pair.gap = gap;
  pair.speed = speed_along(pair.part, pair.normal, nullptr);
  pair.acceleration = motion.bound.acceleration;
  set_due(pair, s, gap - kAim * tolerance_);
  return pair.due - s > 0.1 * (motion.end - s);
}

// Renews the proof with the exact distance; true when the part touches and has to stop.
bool Closing::renew_by_distance(Pair& pair, double s) {
  ++queries_;
  const auto p = static_cast<std::size_t>(pair.part);
  const PartMotion& motion = motion_[p];
  const Shape& shape = hand_->parts()[p].shape;
  DistanceOptions options;
  options.guess = pair.normal;
  options.stop_above = motion.bound.speed * (motion.end - s) + 1.001 * tolerance_;
  const Separation found = pair.obstacle != nullptr
                               ? distance(shape, state_->part[p], *pair.obstacle, options)
                               : distance(shape, state_->part[p], *pair.shape, *pair.pose, options);
  pair.at = s;
  pair.gap = found.distance;
  if (found.bound_only) {  // out of reach
    pair.due = kNever;
    return false;
  }
  if (found.overlap || found.distance <= 0) return true;
  pair.normal = found.normal;
  pair.obstacle_top = found.normal.dot(found.on_b);
  pair.acceleration = motion.bound.acceleration;
  double room = found.distance - kAim * tolerance_;
  if (found.distance <= tolerance_) {
    if (speed_along(pair.part, pair.normal, &found.on_a) > -kMovingAway * motion.bound.speed) return true;
    room = found.distance;
  }
  pair.speed = speed_along(pair.part, pair.normal, nullptr);
  set_due(pair, s, room);
  return pair.due - s < kSmallestStep;
}

}  // namespace evograsp::sim

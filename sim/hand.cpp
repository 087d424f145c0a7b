#include "sim/hand.h"

#include <algorithm>
#include <cmath>

#include "common/det_math.h"
#include "sim/gjk.h"

namespace evograsp::sim {
namespace {

constexpr int kMaxParts = 256;
constexpr double kLargest = 10;            // m or rad: beyond this a hand file is in the wrong units
constexpr int kMostBoxes = 3000;           // of joint values looked at to show that two parts never meet
constexpr double kPresetClearance = 1e-3;  // m: parts this near at the preset are neighbours, not obstacles

tl::unexpected<Error> bad(const std::string& what) {
  return fail(ErrorCode::kInvalid, "hand: " + what);
}

bool sane(const Vec3& v) {
  return is_finite(v) && v.norm() < kLargest;
}

// A unit vector, or the fallback when the bundle gives none.
Result<Vec3> unit(const proto::Vec3& v, bool given, const Vec3& fallback, const char* what) {
  if (!given) return fallback;
  const Vec3 axis = from_proto(v);
  if (!sane(axis) || !(axis.norm() > 1e-6)) return bad(std::string(what) + " is not a direction");
  return Vec3(axis / axis.norm());
}

// The largest distance of a part's points from an axis (unit) through `point`, or from the point itself when
// the axis is zero; all in the link's frame.
double farthest(const HandPart& part, const Vec3& point, const Vec3& axis) {
  const auto distance_of = [&](const Vec3& p) {
    const Vec3 d = p - point;
    return axis.isZero() ? d.norm() : axis.cross(d).norm();
  };
  const Shape& s = part.shape;
  double most = 0;
  if (s.core == Core::kHull) {
    for (std::size_t i = 0; i < s.x.size(); ++i)
      most = std::max(most, distance_of(part.pose * Vec3(s.x[i], s.y[i], s.z[i])));
  } else {  // the corners of the core's box hold the core
    for (int i = 0; i < 8; ++i) {
      const Vec3 sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      most = std::max(most, distance_of(part.pose * Vec3(sign.cwiseProduct(s.half))));
    }
  }
  return most + s.sweep;
}

}  // namespace

Pose HandJoint::child(const Pose& X_WP, double value) const {
  if (prismatic) {
    const Mat3 r = X_WP.rotation * origin.rotation;
    return {r, X_WP * origin.position + r * (value * axis)};
  }
  double s, c;
  det::sincos(value, &s, &c);
  const Mat3 local = fixed + c * even + s * odd;
  return {X_WP.rotation * local, X_WP * origin.position};
}

Result<HandModel> HandModel::create(const proto::HandBundle& bundle, double tolerance) {
  HandModel hand;
  if (auto ok = hand.read_links(bundle); !ok) return tl::unexpected(ok.error());
  if (auto ok = hand.read_joints(bundle); !ok) return tl::unexpected(ok.error());
  if (auto ok = hand.read_motors(bundle); !ok) return tl::unexpected(ok.error());
  if (auto ok = hand.read_frames(bundle); !ok) return tl::unexpected(ok.error());
  hand.derive_bounds();
  hand.derive_collisions(tolerance);
  hand.derive_planar();
  return hand;
}

Status HandModel::read_links(const proto::HandBundle& bundle) {
  const int links = bundle.link_size();
  if (links < 1 || links > kMaxJoints + 1) return bad("needs 1 to 65 links");
  if (bundle.joint_size() != links - 1) return bad("needs one joint a link, but for the palm");
  for (int l = 0; l < links; ++l) {
    material_.push_back(bundle.link(l).material());
    for (const proto::ConvexPart& part : bundle.link(l).part()) {
      Result<Shape> shape = Shape::from_proto(part);
      if (!shape) return bad("link " + bundle.link(l).name() + ": " + shape.error().message);
      HandPart p;
      p.link = l;
      p.pose = from_proto(part.pose());
      p.shape = std::move(*shape);
      if (!is_finite(p.pose) || !sane(p.pose.position)) return bad("a part is not at a finite place");
      parts_.push_back(std::move(p));
    }
  }
  if (parts_.empty() || parts_.size() > kMaxParts) return bad("needs 1 to 256 convex parts");
  return {};
}

Status HandModel::read_joints(const proto::HandBundle& bundle) {
  if (bundle.preset_size() != 0 && bundle.preset_size() != bundle.joint_size())
    return bad("has not one preset value a joint");
  ancestors_.assign(1, 0);
  for (int j = 0; j < bundle.joint_size(); ++j) {
    const proto::HandBundle::Joint& in = bundle.joint(j);
    const std::string name = "joint " + in.name();
    if (in.parent_link() > static_cast<unsigned>(j)) return bad(name + " stands before its parent link");
    HandJoint joint;
    joint.prismatic = in.prismatic();
    joint.parent_link = static_cast<int>(in.parent_link());
    Result<Vec3> axis = unit(in.axis(), in.has_axis(), Vec3::UnitZ(), name.c_str());
    if (!axis) return tl::unexpected(axis.error());
    joint.axis = *axis;
    joint.lower = in.lower();
    joint.upper = in.upper();
    if (!(joint.lower <= joint.upper && std::fabs(joint.lower) < kLargest &&
          std::fabs(joint.upper) < kLargest))
      return bad(name + " has no sane limits");
    joint.origin = from_proto(in.origin());
    if (!is_finite(joint.origin) || !sane(joint.origin.position)) return bad(name + " has no sane origin");
    const Vec3& a = joint.axis;
    const Mat3 along = a * a.transpose();
    Mat3 cross;
    cross << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    joint.fixed = joint.origin.rotation * along;
    joint.even = joint.origin.rotation - joint.fixed;
    joint.odd = joint.origin.rotation * cross;
    const double preset = bundle.preset_size() ? bundle.preset(j) : std::clamp(0.0, joint.lower, joint.upper);
    if (!(preset >= joint.lower - 1e-9 && preset <= joint.upper + 1e-9))
      return bad(name + " has its preset outside its limits");
    preset_.push_back(std::clamp(preset, joint.lower, joint.upper));
    const JointSet above = ancestors_[static_cast<std::size_t>(joint.parent_link)];
    ancestors_.push_back(above | JointSet{1} << j);
    joints_.push_back(joint);
  }
  return {};
}

Status HandModel::read_motors(const proto::HandBundle& bundle) {
  ratio_.assign(joints_.size(), 0);
  JointSet used = 0;
  for (const proto::HandBundle::Motor& in : bundle.motor()) {
    const std::string name = "motor " + in.name();
    if (in.ratio_size() != in.joint_size()) return bad(name + " has not one ratio a joint");
    HandMotor motor;
    motor.name = in.name();
    for (int i = 0; i < in.joint_size(); ++i) {
      if (in.joint(i) >= joints_.size()) return bad(name + " moves a joint that is not there");
      if (!(std::fabs(in.ratio(i)) <= 100)) return bad(name + " has a ratio beyond 100");
      const int j = static_cast<int>(in.joint(i));
      if (used >> j & 1) return bad(name + " shares a joint");
      used |= JointSet{1} << j;
      if (in.hold() || in.ratio(i) == 0 || bundle.joint(j).locked()) continue;
      ratio_[static_cast<std::size_t>(j)] = in.ratio(i);
      motor.joint.push_back(j);
      motor.joints |= JointSet{1} << j;
    }
    for (int l = 0; l < link_count(); ++l)
      if (ancestors(l) & motor.joints) motor.link.push_back(l);
    for (std::size_t p = 0; p < parts_.size(); ++p)
      if (ancestors(parts_[p].link) & motor.joints) motor.part.push_back(static_cast<int>(p));
    if (!motor.joint.empty()) motors_.push_back(std::move(motor));
  }
  return {};
}

Status HandModel::read_frames(const proto::HandBundle& bundle) {
  auto approach = unit(bundle.approach_axis(), bundle.has_approach_axis(), Vec3::UnitZ(), "approach axis");
  if (!approach) return tl::unexpected(approach.error());
  auto finger = unit(bundle.finger_axis(), bundle.has_finger_axis(), Vec3::UnitX(), "finger axis");
  if (!finger) return tl::unexpected(finger.error());
  if (approach->cross(*finger).norm() < 0.1) return bad("approach axis and finger axis are parallel");
  approach_axis_ = *approach;
  finger_axis_ = *finger;
  tool_point_ = from_proto(bundle.tool_point());
  standoff_ = bundle.standoff();
  if (!sane(tool_point_)) return bad("tool point is not finite");
  if (!(standoff_ >= 0 && standoff_ < kLargest)) return bad("standoff is out of range");
  thumb_tip_ = tool_point_;
  if (bundle.has_thumb_tip_link()) {
    if (bundle.thumb_tip_link() >= static_cast<unsigned>(link_count())) return bad("thumb tip has no link");
    thumb_link_ = static_cast<int>(bundle.thumb_tip_link());
    thumb_tip_ = from_proto(bundle.thumb_tip());
    if (!sane(thumb_tip_)) return bad("thumb tip is not finite");
  }
  return {};
}

void HandModel::forward(std::span<const double> values, const Pose& X_WH, std::span<Pose> X_WL) const {
  X_WL[0] = X_WH;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    X_WL[j + 1] = joints_[j].child(X_WL[static_cast<std::size_t>(joints_[j].parent_link)], values[j]);
}

// Levers grow from the part inward: what lies beyond a child joint is within the child's own reach of the
// child's origin, wherever its joints stand.
void HandModel::derive_bounds() {
  lever_.assign(joints_.size() * parts_.size(), 0);
  reach_.assign(joints_.size() * parts_.size(), 0);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    if (parts_[p].link == 0) continue;
    int j = parts_[p].link - 1;
    double from_axis = farthest(parts_[p], Vec3::Zero(), joints_[static_cast<std::size_t>(j)].axis);
    double from_origin = farthest(parts_[p], Vec3::Zero(), Vec3::Zero());
    for (;;) {
      const HandJoint& joint = joints_[static_cast<std::size_t>(j)];
      lever_[static_cast<std::size_t>(j) * parts_.size() + p] = from_axis;
      const double travel = joint.prismatic ? std::max(std::fabs(joint.lower), std::fabs(joint.upper)) : 0;
      reach_[static_cast<std::size_t>(j) * parts_.size() + p] = from_origin + travel;
      if (joint.parent_link == 0) break;
      const HandJoint& outer = joints_[static_cast<std::size_t>(joint.parent_link - 1)];
      const Vec3 axis_in_outer = joint.origin.rotation * joint.axis;
      const bool parallel = !joint.prismatic && axis_in_outer.cross(outer.axis).norm() < 1e-12;
      from_axis =
          outer.axis.cross(joint.origin.position).norm() + travel + (parallel ? from_axis : from_origin);
      from_origin += joint.origin.position.norm() + travel;
      j = joint.parent_link - 1;
    }
  }
}

HandModel::MotionBound HandModel::motion_bound(int part, JointSet active) const {
  MotionBound bound;
  const JointSet moving = ancestors(parts_[static_cast<std::size_t>(part)].link) & active;
  double turning = 0;  // sum of the rates of the revolute joints nearer the palm
  for (JointSet rest = moving; rest != 0; rest &= rest - 1) {
    const auto j = static_cast<std::size_t>(__builtin_ctzll(rest));
    const double rate = std::fabs(ratio_[j]);
    const double point_speed =
        joints_[j].prismatic ? rate : rate * lever_[j * parts_.size() + static_cast<std::size_t>(part)];
    bound.speed += point_speed;
    // Centripetal w x (w x r) of the joint itself, and the nearer joints' turning of its velocity, twice.
    bound.acceleration += (2 * turning + (joints_[j].prismatic ? 0 : rate)) * point_speed;
    if (!joints_[j].prismatic) turning += rate;
  }
  return bound;
}

void HandModel::derive_collisions(double tolerance) {
  std::vector<Pose> X_HL(static_cast<std::size_t>(link_count()));
  forward(preset_, Pose{}, X_HL);
  for (HandPart& part : parts_) part.preset_pose = X_HL[static_cast<std::size_t>(part.link)] * part.pose;
  const auto parent = [&](int link) {
    return link == 0 ? -1 : joints_[static_cast<std::size_t>(link - 1)].parent_link;
  };
  JointSet moving = 0;
  for (const HandMotor& motor : motors_) moving |= motor.joints;
  may_collide_.assign(parts_.size() * parts_.size(), 0);
  for (std::size_t a = 0; a < parts_.size(); ++a) {
    for (std::size_t b = 0; b < parts_.size(); ++b) {
      const int la = parts_[a].link, lb = parts_[b].link;
      if (la == lb || parent(la) == lb || parent(lb) == la || !(ancestors(la) & moving)) continue;
      const Separation s =
          distance(parts_[a].shape, parts_[a].preset_pose, parts_[b].shape, parts_[b].preset_pose);
      const bool fixed = !(ancestors(lb) & moving);
      may_collide_[a * parts_.size() + b] =
          s.distance > kPresetClearance &&
          (!fixed || can_meet(static_cast<int>(a), static_cast<int>(b), tolerance));
    }
  }
}

// Branch and bound over the joint values the motors can reach: a box of them is done with when the distance
// at its centre exceeds what the joints can move any point of the part within it.
bool HandModel::can_meet(int part, int fixed_part, double tolerance) const {
  struct Box {
    std::vector<double> centre, half;
  };
  const auto p = static_cast<std::size_t>(part), q = static_cast<std::size_t>(fixed_part);
  const JointSet chain = ancestors(parts_[p].link);
  Box all{preset_, std::vector<double>(joints_.size(), 0)};
  for (JointSet rest = chain; rest != 0; rest &= rest - 1) {
    const auto j = static_cast<std::size_t>(__builtin_ctzll(rest));
    if (ratio_[j] == 0) continue;
    const double end = ratio_[j] > 0 ? joints_[j].upper : joints_[j].lower;
    all.centre[j] = 0.5 * (preset_[j] + end);
    all.half[j] = 0.5 * std::fabs(end - preset_[j]);
  }
  std::vector<Box> open{std::move(all)};
  std::vector<Pose> X_HL(static_cast<std::size_t>(link_count()));
  for (int looked = 0; !open.empty(); ++looked) {
    if (looked == kMostBoxes) return true;
    Box box = std::move(open.back());
    open.pop_back();
    forward(box.centre, Pose{}, X_HL);
    const Pose pose = X_HL[static_cast<std::size_t>(parts_[p].link)] * parts_[p].pose;
    const double d = distance(parts_[p].shape, pose, parts_[q].shape, parts_[q].preset_pose).distance;
    if (d <= tolerance) return true;
    double reachable = 0, most = 0;
    std::size_t widest = 0;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const double moves = box.half[j] * (joints_[j].prismatic ? 1 : lever_[j * parts_.size() + p]);
      reachable += moves;
      if (moves > most) {
        most = moves;
        widest = j;
      }
    }
    if (d - reachable > tolerance) continue;
    box.half[widest] *= 0.5;
    Box other = box;
    box.centre[widest] -= box.half[widest];
    other.centre[widest] += other.half[widest];
    open.push_back(std::move(box));
    open.push_back(std::move(other));
  }
  return false;
}

void HandModel::derive_planar() {
  std::vector<Pose> X_HL(static_cast<std::size_t>(link_count()));
  forward(preset_, Pose{}, X_HL);
  for (HandMotor& motor : motors_) {
    for (int part : motor.part) {
      const JointSet chain = ancestors(parts_[static_cast<std::size_t>(part)].link);
      const JointSet beyond_first = chain & ~((chain & motor.joints & -(chain & motor.joints)) - 1);
      bool planar = true;
      Vec3 axis = Vec3::Zero();
      for (JointSet rest = beyond_first; rest != 0; rest &= rest - 1) {
        const auto j = static_cast<std::size_t>(__builtin_ctzll(rest));
        if (ratio_[j] == 0) continue;  // stands still
        const Vec3 a = X_HL[j + 1].rotation * joints_[j].axis;
        if (axis.isZero()) axis = a;
        planar = planar && !joints_[j].prismatic && (motor.joints >> j & 1) && axis.cross(a).norm() < 1e-9;
      }
      motor.planar.push_back(planar);
    }
  }
}

}  // namespace evograsp::sim

// An articulated hand as data: its tree of links, its convex parts, its motors, and the bounds on how fast a
// part can move that make continuous collision exact.
//
// Frames: link 0 is the palm (frame H); joint i moves link i + 1; parents stand before children. Immutable
// after construction, thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "sim/shape.h"

namespace evograsp::sim {

inline constexpr int kMaxJoints = 64;  // a set of joints is one machine word
using JointSet = std::uint64_t;

struct HandJoint {
  bool prismatic = false;
  int parent_link = 0;
  Vec3 axis = Vec3::UnitZ();  // unit, in the joint frame, which is also the child link's
  double lower = 0, upper = 0;
  Pose origin;  // joint frame in the parent link's frame at value 0
  // Rotation of a revolute joint's child in its parent: fixed + cos(q) even + sin(q) odd.
  Mat3 fixed = Mat3::Zero(), even = Mat3::Zero(), odd = Mat3::Zero();

  // X_WC of the child link, given the parent link's pose and the joint's value (rad or m).
  Pose child(const Pose& X_WP, double value) const;
};

struct HandPart {
  int link = 0;
  Pose pose;  // in the link's frame
  Shape shape;
  Pose preset_pose;  // in the palm's frame, all joints at their preset
};

struct HandMotor {
  std::string name;
  std::vector<int> joint;
  JointSet joints = 0;
  std::vector<int> link;  // the links its joints move, parents before children
  std::vector<int> part;  // the parts on these links
  // One a part: all its joints turn about parallel axes, so that its extent along that axis never changes.
  std::vector<std::uint8_t> planar;
};

class HandModel {
 public:
  // Everything is checked: counts, finite numbers, the tree, limits, motors that share no joint. `tolerance`
  // (m): parts of the hand that never come this near to each other are never asked about.
  static Result<HandModel> create(const proto::HandBundle& bundle, double tolerance = 0.01);

  int link_count() const { return static_cast<int>(ancestors_.size()); }
  int joint_count() const { return static_cast<int>(joints_.size()); }
  const std::vector<HandJoint>& joints() const { return joints_; }
  const std::vector<HandPart>& parts() const { return parts_; }
  // The motors that close (not those that hold), in closing order.
  const std::vector<HandMotor>& motors() const { return motors_; }
  const std::vector<double>& preset() const { return preset_; }
  // Motion of a joint for one unit of its motor's travel; 0 for joints no closing motor moves.
  double ratio(int joint) const { return ratio_[static_cast<std::size_t>(joint)]; }
  // The joints whose motion moves a link.
  JointSet ancestors(int link) const { return ancestors_[static_cast<std::size_t>(link)]; }
  const std::string& material(int link) const { return material_[static_cast<std::size_t>(link)]; }

  const Vec3& approach_axis() const { return approach_axis_; }
  const Vec3& finger_axis() const { return finger_axis_; }
  const Vec3& tool_point() const { return tool_point_; }
  double standoff() const { return standoff_; }
  // Where theta's first vector ends: a point of a link; for a hand without a thumb the palm's tool point.
  int thumb_link() const { return thumb_link_; }
  const Vec3& thumb_tip() const { return thumb_tip_; }

  // Poses of all links in the world: X_WL[link].
  void forward(std::span<const double> values, const Pose& X_WH, std::span<Pose> X_WL) const;

  // Upper bounds over every configuration, per unit of the motors' travel, when the joints in `active` move:
  // speed of any point of a part (m a unit) and its acceleration (m a unit squared).
  struct MotionBound {
    double speed = 0, acceleration = 0;
  };
  MotionBound motion_bound(int part, JointSet active) const;
  // Largest distance of any point of a part from the origin of a joint that moves it, in any configuration.
  double reach(int joint, int part) const {
    return reach_[static_cast<std::size_t>(joint) * parts_.size() + static_cast<std::size_t>(part)];
  }

  // Whether two parts may stop each other: not those on one link or on neighbours in the tree, nor those that
  // touch already at the preset, nor those that cannot meet whatever the motors do.
  bool may_collide(int part_a, int part_b) const {
    return may_collide_[static_cast<std::size_t>(part_a) * parts_.size() +
                        static_cast<std::size_t>(part_b)] != 0;
  }

 private:
  Status read_links(const proto::HandBundle& bundle);
  Status read_joints(const proto::HandBundle& bundle);
  Status read_motors(const proto::HandBundle& bundle);
  Status read_frames(const proto::HandBundle& bundle);
  void derive_bounds();
  void derive_collisions(double tolerance);
  bool can_meet(int part, int fixed_part, double tolerance) const;
  void derive_planar();

  std::vector<HandJoint> joints_;
  std::vector<HandPart> parts_;
  std::vector<HandMotor> motors_;
  std::vector<double> preset_, ratio_;
  std::vector<JointSet> ancestors_;
  std::vector<std::string> material_;
  std::vector<double> lever_;  // [joint x part]: largest distance of the part's points from the joint's axis
  std::vector<double> reach_;  // [joint x part]: the same from the joint's origin
  std::vector<std::uint8_t> may_collide_;
  Vec3 approach_axis_ = Vec3::UnitZ(), finger_axis_ = Vec3::UnitX();
  Vec3 tool_point_ = Vec3::Zero(), thumb_tip_ = Vec3::Zero();
  int thumb_link_ = 0;
  double standoff_ = 0;
};

}  // namespace evograsp::sim

#include "assets/hand_tree.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "assets/hand_geometry.h"
#include "assets/parts.h"
#include "assets/urdf.h"
#include "common/det_math.h"

namespace evograsp::assets {
namespace {

class Builder {
 public:
  Builder(const urdf::ModelInterface& model, const GeometrySource& geometry,
          std::vector<std::string>& warnings)
      : model_(model), geometry_(geometry), warnings_(warnings) {}

  Result<HandTree> build(const std::string& palm_link, const Pose& X_LP) {
    const urdf::LinkConstSharedPtr palm = model_.getLink(palm_link);
    if (!palm) return fail(ErrorCode::kInvalid, "palm_link: the URDF has no link '" + palm_link + "'");
    tree_.links.push_back({palm->name, {}, 0, Vec3::Zero()});
    if (const Status ok = place(*palm, 0, X_LP.inverse()); !ok) return tl::unexpected(ok.error());
    if (tree_.joints.empty()) {
      return fail(ErrorCode::kInvalid,
                  "palm_link '" + palm_link + "': no moving joint below it, nothing to grasp with");
    }
    return std::move(tree_);
  }

 private:
  // Adds a URDF link at `pose` in hand link `index`, then everything below it.
  Status place(const urdf::Link& link, int index, const Pose& pose) {
    if (!tree_.placed.emplace(link.name, HandTree::Placed{index, pose}).second) {
      return fail(ErrorCode::kInvalid, "link '" + link.name + "' is its own ancestor");
    }
    add_mass(link, tree_.links[index], pose);
    Result<std::vector<proto::ConvexPart>> parts = link_parts(link, pose, geometry_, warnings_);
    if (!parts) return tl::unexpected(parts.error());
    std::move(parts->begin(), parts->end(), std::back_inserter(tree_.links[index].parts));
    for (const urdf::JointSharedPtr& joint : sorted_joints(link)) {
      const urdf::LinkConstSharedPtr child = model_.getLink(joint->child_link_name);
      if (!child)
        return fail(ErrorCode::kInvalid,
                    "joint '" + joint->name + "': no link '" + joint->child_link_name + "'");
      const Pose at = pose * snapped(joint->parent_to_joint_origin_transform);
      if (!is_finite(at))
        return fail(ErrorCode::kInvalid, "joint '" + joint->name + "': origin is not finite");
      if (joint->type == urdf::Joint::FIXED) {
        if (const Status ok = place(*child, index, at); !ok) return ok;
      } else if (const Status ok = add_joint(*joint, *child, index, at); !ok) {
        return ok;
      }
    }
    return {};
  }

  Status add_joint(const urdf::Joint& joint, const urdf::Link& child, int parent, const Pose& origin) {
    if (joint.type == urdf::Joint::FLOATING || joint.type == urdf::Joint::PLANAR) {
      return fail(ErrorCode::kUnsupported,
                  "joint '" + joint.name + "': floating and planar joints are not supported");
    }
    if (tree_.links.size() >= kMaxHandLinks) {
      return fail(ErrorCode::kInvalid,
                  "more than " + std::to_string(kMaxHandLinks) + " moving links below the palm");
    }
    HandJoint out;
    out.name = joint.name;
    out.prismatic = joint.type == urdf::Joint::PRISMATIC;
    out.parent = parent;
    out.origin = origin;
    const auto axis = direction_of({joint.axis.x, joint.axis.y, joint.axis.z});
    if (!axis) return fail(ErrorCode::kInvalid, "joint '" + joint.name + "': the axis is zero or not finite");
    out.axis = *axis;
    if (const Status ok = set_limits(joint, out); !ok) return ok;
    if (joint.mimic) {
      out.mimic = joint.mimic->joint_name;
      out.multiplier = joint.mimic->multiplier;
      out.offset = joint.mimic->offset;
    }
    tree_.joints.push_back(out);
    tree_.links.push_back({child.name, {}, 0, Vec3::Zero()});
    return place(child, static_cast<int>(tree_.links.size()) - 1, {});
  }

  Status set_limits(const urdf::Joint& joint, HandJoint& out) {
    if (joint.type == urdf::Joint::CONTINUOUS) {
      out.lower = -det::kPi;
      out.upper = det::kPi;
      return {};
    }
    if (!joint.limits) return fail(ErrorCode::kInvalid, "joint '" + joint.name + "': no <limit>");
    out.lower = joint.limits->lower;
    out.upper = joint.limits->upper;
    const double most = out.prismatic ? 1.0 : 2 * det::kPi;
    if (!(out.lower <= out.upper) || !(std::fabs(out.lower) <= most) || !(std::fabs(out.upper) <= most)) {
      return fail(ErrorCode::kInvalid, "joint '" + joint.name + "': limits must be lower <= upper, within " +
                                           (out.prismatic ? "1 m" : "one turn"));
    }
    return {};
  }

  void add_mass(const urdf::Link& link, HandLink& into, const Pose& pose) {
    if (!link.inertial) return;
    const double mass = link.inertial->mass;
    const Vec3 centre = pose * snapped(link.inertial->origin).position;
    if (!(mass > 0) || !std::isfinite(mass) || !is_finite(centre)) return;
    into.centre = (into.mass * into.centre + mass * centre) / (into.mass + mass);
    into.mass += mass;
  }

  // By name: urdfdom's own order is that of its map, stated here so that numbering can never change.
  static std::vector<urdf::JointSharedPtr> sorted_joints(const urdf::Link& link) {
    std::vector<urdf::JointSharedPtr> joints = link.child_joints;
    std::sort(joints.begin(), joints.end(), [](const auto& a, const auto& b) { return a->name < b->name; });
    return joints;
  }

  const urdf::ModelInterface& model_;
  const GeometrySource& geometry_;
  std::vector<std::string>& warnings_;
  HandTree tree_;
};

}  // namespace

int HandTree::find_joint(const std::string& name) const {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

std::vector<Pose> HandTree::forward(const std::vector<double>& q) const {
  std::vector<Pose> frames(links.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const HandJoint& joint = joints[i];
    const Pose motion = joint.prismatic ? Pose{Mat3::Identity(), q[i] * joint.axis}
                                        : Pose{rotation_about(joint.axis, q[i]), Vec3::Zero()};
    frames[i + 1] = frames[joint.parent] * joint.origin * motion;
  }
  return frames;
}

Result<HandTree> build_hand_tree(const urdf::ModelInterface& model, const std::string& palm_link,
                                 const Pose& X_LP, const GeometrySource& geometry,
                                 std::vector<std::string>& warnings) {
  return Builder(model, geometry, warnings).build(palm_link, X_LP);
}

}  // namespace evograsp::assets

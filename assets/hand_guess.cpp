#include "assets/hand_guess.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "assets/parts.h"

namespace evograsp::assets {
namespace {

// Chains of moving joints that hang on a link, fixed joints looked through. `seen` guards against cycles.
int branches(const urdf::ModelInterface& model, const urdf::Link& link, int depth = 0) {
  if (depth > 64) return 0;
  int count = 0;
  for (const urdf::JointSharedPtr& joint : link.child_joints) {
    if (joint->type != urdf::Joint::FIXED) {
      ++count;
    } else if (const auto child = model.getLink(joint->child_link_name)) {
      count += branches(model, *child, depth + 1);
    }
  }
  return count;
}

// A chain from the palm to a leaf: joint indices, root first. Where it forks it follows the first child.
std::vector<std::vector<int>> chains_of(const HandTree& tree) {
  std::vector<std::vector<int>> chains;
  for (std::size_t root = 0; root < tree.joints.size(); ++root) {
    if (tree.joints[root].parent != 0) continue;
    std::vector<int> chain{static_cast<int>(root)};
    for (std::size_t j = root + 1; j < tree.joints.size(); ++j) {
      if (tree.joints[j].parent == chain.back() + 1) chain.push_back(static_cast<int>(j));
    }
    chains.push_back(chain);
  }
  return chains;
}

double closing_limit(const HandJoint& joint) {
  return std::fabs(joint.upper) >= std::fabs(joint.lower) ? joint.upper : joint.lower;
}

// Joints of a chain that curl it: those parallel to its last joint (all, when they slide).
std::vector<int> curling(const HandTree& tree, const std::vector<int>& chain) {
  const std::vector<Pose> frames = tree.forward(std::vector<double>(tree.joints.size(), 0.0));
  const auto axis = [&](int j) { return Vec3(frames[j + 1].rotation * tree.joints[j].axis); };
  std::vector<int> curl;
  for (const int j : chain) {
    const bool same = std::fabs(axis(j).dot(axis(chain.back()))) > 0.7 &&
                      tree.joints[j].prismatic == tree.joints[chain.back()].prismatic;
    if (same && closing_limit(tree.joints[j]) != 0) curl.push_back(j);
  }
  return curl;
}

// Farthest point of a link's shapes from its frame, or the frame itself.
Vec3 tip_of(const HandLink& link) {
  Vec3 tip = Vec3::Zero();
  for (const proto::ConvexPart& part : link.parts) {
    for (const Vec3& d : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
      for (const double sign : {1.0, -1.0}) {
        const double reach = support(part, sign * d);
        if (reach > tip.norm()) tip = reach * sign * d;
      }
    }
  }
  return tip;
}

std::vector<double> curled(const HandTree& tree, const std::vector<std::vector<int>>& chains, double share) {
  std::vector<double> q;
  for (const HandJoint& joint : tree.joints) q.push_back(std::clamp(0.0, joint.lower, joint.upper));
  for (const auto& chain : chains) {
    for (const int j : curling(tree, chain)) q[j] = share * closing_limit(tree.joints[j]);
  }
  return q;
}

// The coordinate axis nearest to a unit vector, when it is within about 32 degrees: hands are drawn along
// their axes.
Vec3 snapped_axis(const Vec3& v) {
  for (int k = 0; k < 3; ++k) {
    if (std::fabs(v[k]) > 0.85) return Vec3::Unit(k) * (v[k] > 0 ? 1.0 : -1.0);
  }
  return v;
}

Vec3 unit_or(const Vec3& v, const Vec3& fallback) {
  return v.norm() > 1e-6 ? Vec3(v / v.norm()) : fallback;
}

}  // namespace

Result<std::string> guess_palm(const urdf::ModelInterface& model) {
  std::string best;
  int most = 1;
  std::vector<std::pair<urdf::LinkConstSharedPtr, int>> queue{{model.getRoot(), 0}};
  for (std::size_t i = 0; i < queue.size() && i < 2048; ++i) {  // breadth first: nearest the root wins a tie
    const auto link = queue[i].first;
    const int count = branches(model, *link);
    if (count > most) most = count, best = link->name;
    for (const urdf::LinkSharedPtr& child : link->child_links) queue.emplace_back(child, queue[i].second + 1);
  }
  if (best.empty()) {
    return fail(ErrorCode::kInvalid,
                "not a hand: no link has two or more moving chains below it (an arm?); for a hand on it, "
                "write a hand "
                "file that names palm_link");
  }
  return best;
}

void guess_frame(const HandTree& tree, proto::HandFile& file, std::vector<std::string>& warnings) {
  const auto chains = chains_of(tree);
  const std::vector<Pose> open = tree.forward(curled(tree, chains, 0)),
                          half = tree.forward(curled(tree, chains, 0.5));
  std::vector<Vec3> travel, tips;
  Vec3 fingers = Vec3::Zero(), motion = Vec3::Zero(), middle = Vec3::Zero();
  for (const auto& chain : chains) {
    const int last = chain.back() + 1;
    const Vec3 tip = tip_of(tree.links[last]), opened = open[last] * tip, closed = half[last] * tip;
    fingers += unit_or(opened - open[chain.front() + 1].position, Vec3::Zero());
    travel.push_back(closed - opened);
    tips.push_back(tip);
    motion += travel.back();
    middle += closed / static_cast<double>(chains.size());
  }
  Vec3 finger = snapped_axis(unit_or(fingers, Vec3::UnitX()));
  // Fingers that meet across the palm (jaws) have no motion in common: they point at the object themselves.
  const Vec3 sideways = motion - motion.dot(finger) * finger;
  Vec3 approach = snapped_axis(unit_or(sideways, finger));
  if (sideways.norm() < 0.005) approach = finger, finger = any_perpendicular(approach);
  *file.mutable_approach_axis() = to_proto(approach);
  *file.mutable_finger_axis() = to_proto(finger);
  *file.mutable_tool_point() = to_proto(middle);
  std::size_t thumb = 0;
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < chains.size(); ++i) {
    const double along = travel[i].dot(unit_or(motion - travel[i], approach));
    if (along < least) least = along, thumb = i;
  }
  const int last = chains[thumb].back() + 1;
  file.set_thumb_tip_link(tree.links[last].name);
  *file.mutable_thumb_tip() = to_proto(tips[thumb]);
  warnings.push_back("guessed: palm '" + file.palm_link() + "', thumb ends in '" + file.thumb_tip_link() +
                     "'");
}

void guess_motors(const HandTree& tree, proto::HandFile& file, std::vector<std::string>& warnings) {
  const bool mimics =
      std::any_of(tree.joints.begin(), tree.joints.end(), [](const auto& j) { return !j.mimic.empty(); });
  const auto add = [&](const std::string& name, const std::vector<int>& joints) {
    if (joints.empty()) return;
    proto::Motor& motor = *file.add_motor();
    motor.set_name(name);
    for (const int j : joints) {
      proto::Coupling& coupling = *motor.add_joint();
      coupling.set_joint(tree.joints[j].name);
      coupling.set_ratio(closing_limit(tree.joints[j]) > 0 ? 1 : -1);
    }
  };
  if (mimics) {  // followers join their leaders when the hand is assembled
    for (std::size_t j = 0; j < tree.joints.size(); ++j) {
      if (tree.joints[j].mimic.empty() && closing_limit(tree.joints[j]) != 0)
        add(tree.joints[j].name, {static_cast<int>(j)});
    }
  } else {
    for (const auto& chain : chains_of(tree)) add(tree.links[chain.front() + 1].name, curling(tree, chain));
  }
  warnings.push_back("guessed: " + std::to_string(file.motor_size()) + " motors");
}

}  // namespace evograsp::assets

#include "sim/contacts.h"

#include <algorithm>

namespace evograsp::sim {
namespace {

constexpr double kPrecision = 1e-9;  // m: contacts decide a grasp's quality, so they are exact
constexpr double kTie = 1e-7;        // m: equally near; the first part keeps the contact

bool canonical(const Contact& a, const Contact& b) {
  if (a.link != b.link) return a.link < b.link;
  if (a.part != b.part) return a.part < b.part;
  for (int i = 0; i < 3; ++i)
    if (a.point[i] != b.point[i]) return a.point[i] < b.point[i];
  for (int i = 0; i < 3; ++i)
    if (a.normal[i] != b.normal[i]) return a.normal[i] < b.normal[i];
  return a.gap < b.gap;
}

// Whether a point is nearer to the shape than `gap` (or as near, and the shape comes first).
bool nearer(const Shape& point, const Vec3& p, const Shape& shape, const Pose& pose, double gap, bool first) {
  DistanceOptions options;
  const double limit = first ? gap + kTie : gap - kTie;
  options.stop_above = limit;
  const Separation s = distance(point, Pose{Mat3::Identity(), p}, shape, pose, options);
  return !s.bound_only && s.distance < limit;
}

struct Seams {
  const HandModel& hand;
  const HandState& state;
  const PosedWorld& world;
  const PosedWorld::Body& body;
  const Shape point = Shape::ball(0);

  bool looks_at_seam(std::size_t part, int obstacle, const Separation& s) const {
    for (int k = body.first; k < body.first + body.count; ++k) {
      const Obstacle& other = world.obstacle[static_cast<std::size_t>(k)];
      const double reach = s.distance + kTie;
      if (k == obstacle || other.box.squared_distance(s.on_a) > reach * reach) continue;
      if (nearer(point, s.on_a, *other.shape, other.pose, s.distance, k < obstacle)) return true;
    }
    for (std::size_t q = 0; q < hand.parts().size(); ++q) {
      if (q == part || hand.parts()[q].link != hand.parts()[part].link) continue;
      if (nearer(point, s.on_b, hand.parts()[q].shape, state.part[q], s.distance, q < part)) return true;
    }
    return false;
  }
};

}  // namespace

int collect_contacts(const HandModel& hand, const HandState& state, const PosedWorld& world, int target,
                     double margin, std::vector<Contact>& contacts) {
  contacts.clear();
  JointSet obstructed_low = 0;
  bool obstructed_last = false;  // the 65th link
  DistanceOptions options;
  options.stop_above = margin;
  options.tolerance = kPrecision;
  const Seams seams{hand, state, world, world.body[static_cast<std::size_t>(target)]};
  const auto obstruct = [&](int link) {
    if (link < kMaxJoints)
      obstructed_low |= JointSet{1} << link;
    else
      obstructed_last = true;
  };
  const auto obstructed = [&](int link) {
    return link < kMaxJoints ? (obstructed_low >> link & 1) != 0 : obstructed_last;
  };
  for (std::size_t p = 0; p < hand.parts().size(); ++p) {
    const HandPart& part = hand.parts()[p];
    const Aabb box = bounds(part.shape, state.part[p]);
    const auto look = [&](int k) {
      const Obstacle& o = world.obstacle[static_cast<std::size_t>(k)];
      if (!box.overlaps(o.box, margin) || (o.object != target && obstructed(part.link))) return;
      const Separation s = distance(part.shape, state.part[p], o, options);
      if (s.bound_only || s.distance > margin) return;
      if (o.object != target) return obstruct(part.link);
      if (s.overlap || seams.looks_at_seam(p, k, s)) return;
      const Patch patch = contact_patch(part.shape, state.part[p], *o.shape, o.pose, s, margin);
      for (int i = 0; i < patch.count; ++i) {
        const PatchPoint& at = patch.point[static_cast<std::size_t>(i)];
        contacts.push_back({at.point, -s.normal, 0, part.link, o.part, at.gap});
      }
    };
    look(0);
    for (const PosedWorld::Body& body : world.body) {
      if (!body.present || !box.overlaps(body.box, margin)) continue;
      for (int k = body.first; k < body.first + body.count; ++k) look(k);
    }
  }
  std::sort(contacts.begin(), contacts.end(), canonical);
  return __builtin_popcountll(obstructed_low) + (obstructed_last ? 1 : 0);
}

}  // namespace evograsp::sim

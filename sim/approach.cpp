#include "sim/approach.h"

#include <algorithm>
#include <limits>

namespace evograsp::sim {
namespace {

constexpr int kMaxSteps = 200;
constexpr double kAim = 0.9;  // steps aim at this part of the tolerance

// The first t >= 0 at which `moving`, translated by t * direction, overlaps `fixed` grown by margin; infinity
// when it never does before `length`.
double entry(const Aabb& moving, const Aabb& fixed, const Vec3& direction, double length, double margin) {
  double from = 0, to = length;
  for (int i = 0; i < 3; ++i) {
    const double lo = fixed.lo[i] - margin - moving.hi[i], hi = fixed.hi[i] + margin - moving.lo[i];
    const double d = direction[i];
    if (d > -1e-12 && d < 1e-12) {
      if (lo > 0 || hi < 0) return std::numeric_limits<double>::infinity();
      continue;
    }
    const double a = lo / d, b = hi / d;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to ? from : std::numeric_limits<double>::infinity();
}

// Where the pair first touches, if before `length`; otherwise `length`.
double first_touch(const Shape& shape, const Pose& start, const Obstacle& obstacle, const Vec3& direction,
                   double enter, double length, double tolerance) {
  double t = enter;
  Pose pose = start;
  DistanceOptions options;
  options.guess = -direction;
  for (int step = 0; step < kMaxSteps && t < length; ++step) {
    pose.position = start.position + t * direction;
    options.stop_above = length - t + tolerance;
    const Separation s = distance(shape, pose, obstacle, options);
    if (s.bound_only) return length;
    if (s.distance <= tolerance) return t;
    const double closing = -s.normal.dot(direction);
    if (closing <= 1e-9) return length;  // convex shapes that part along a line never meet again on it
    t += (s.distance - kAim * tolerance) / closing;
    options.guess = s.normal;
  }
  return std::min(t, length);
}

}  // namespace

ApproachResult approach(const HandModel& hand, const HandState& state, const PosedWorld& world,
                        const Vec3& direction, double length, double tolerance, ApproachScratch& scratch) {
  const int parts = static_cast<int>(hand.parts().size());
  scratch.part_box.resize(hand.parts().size());
  Aabb all;
  for (std::size_t p = 0; p < scratch.part_box.size(); ++p) {
    const Aabb box = bounds(hand.parts()[p].shape, state.part[p]);
    scratch.part_box[p] = box;
    all.lo = p == 0 ? box.lo : Vec3(all.lo.cwiseMin(box.lo));
    all.hi = p == 0 ? box.hi : Vec3(all.hi.cwiseMax(box.hi));
  }
  scratch.candidate.clear();
  const auto consider = [&](int k) {
    const Aabb& fixed = world.obstacle[static_cast<std::size_t>(k)].box;
    if (entry(all, fixed, direction, length, tolerance) > length) return;
    for (int p = 0; p < parts; ++p) {
      const double enter =
          entry(scratch.part_box[static_cast<std::size_t>(p)], fixed, direction, length, tolerance);
      if (enter <= length) scratch.candidate.push_back({enter, p, k});
    }
  };
  consider(0);
  for (const PosedWorld::Body& body : world.body) {
    if (!body.present || entry(all, body.box, direction, length, tolerance) > length) continue;
    for (int k = body.first; k < body.first + body.count; ++k) consider(k);
  }
  std::sort(scratch.candidate.begin(), scratch.candidate.end(), [](const auto& a, const auto& b) {
    if (a.enter != b.enter) return a.enter < b.enter;
    return a.obstacle != b.obstacle ? a.obstacle < b.obstacle : a.part < b.part;
  });
  ApproachResult out{length, false};
  for (const ApproachScratch::Candidate& c : scratch.candidate) {
    if (c.enter >= out.travelled) break;
    const auto p = static_cast<std::size_t>(c.part);
    const Obstacle& obstacle = world.obstacle[static_cast<std::size_t>(c.obstacle)];
    out.travelled = first_touch(hand.parts()[p].shape, state.part[p], obstacle, direction, c.enter,
                                out.travelled, tolerance);
    if (out.travelled <= 0) {
      out.blocked = true;
      break;
    }
  }
  return out;
}

}  // namespace evograsp::sim

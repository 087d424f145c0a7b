#include "assets/resting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "assets/hull.h"
#include "common/det_math.h"

namespace evograsp::assets {
namespace {

constexpr double kLeastShare = 0.03;
constexpr double kSameFace = 0.9659258262890683;  // cosine of 15 degrees
constexpr double kTouching = 1e-3;                // m: points this near to the table support
constexpr double kMargin = 1e-3;                  // m

using Loop = std::vector<int>;

// Solid angle of a triangle seen from the origin (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30(2),
// 1983).
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double up = std::fabs(a.dot(b.cross(c)));
  const double down = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2 * det::atan2(up, down);
}

double solid_angle(const ConvexHull& hull, const Loop& loop, const Vec3& eye) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < loop.size(); ++i)
    sum += solid_angle(hull.vertices[static_cast<std::size_t>(loop[0])] - eye,
                       hull.vertices[static_cast<std::size_t>(loop[i])] - eye,
                       hull.vertices[static_cast<std::size_t>(loop[i + 1])] - eye);
  return sum;
}

// Where every face of a hull rolls to.
class Rolling {
 public:
  Rolling(const ConvexHull& hull, const Vec3& centre) : hull_(hull), centre_(centre) {
    for (std::size_t f = 0; f < hull.faces.size(); ++f) {
      const Loop& loop = hull.faces[f].loop;
      for (std::size_t i = 0; i < loop.size(); ++i)
        across_[{loop[(i + 1) % loop.size()], loop[i]}] = static_cast<int>(f);
    }
  }

  // The face that `face` comes to rest on. Every roll lowers the centre: the walk ends.
  int end_of(int face) const {
    double height = HUGE_VAL;
    for (std::size_t step = 0; step < hull_.faces.size(); ++step) {
      const double now = height_on(face);
      if (!(now < height)) break;
      height = now;
      const int next = rolls_to(face);
      if (next < 0) break;
      face = next;
    }
    return face;
  }

 private:
  double height_on(int face) const {
    const ConvexHull::Face& f = hull_.faces[static_cast<std::size_t>(face)];
    return f.normal == Vec3::Zero() ? 1e300 : f.offset - f.normal.dot(centre_);
  }

  // The neighbour over the edge that the centre is farthest beyond; -1 when it stands over the face. A sliver
  // leads to its lowest neighbour.
  int rolls_to(int face) const {
    const ConvexHull::Face& f = hull_.faces[static_cast<std::size_t>(face)];
    const bool sliver = f.normal == Vec3::Zero();
    double most = 0, lowest = HUGE_VAL;
    int next = -1;
    for (std::size_t i = 0; i < f.loop.size(); ++i) {
      const int a = f.loop[i], b = f.loop[(i + 1) % f.loop.size()];
      const auto found = across_.find({a, b});
      if (found == across_.end()) continue;
      if (sliver) {
        if (height_on(found->second) < lowest) lowest = height_on(found->second), next = found->second;
        continue;
      }
      const Vec3& from = hull_.vertices[static_cast<std::size_t>(a)];
      const Vec3 edge = hull_.vertices[static_cast<std::size_t>(b)] - from;
      const Vec3 outward = edge.cross(f.normal);
      const double length = outward.norm();
      const double beyond = length > 0 ? outward.dot(centre_ - from) / length : 0;
      if (beyond > most) most = beyond, next = found->second;
    }
    return next;
  }

  const ConvexHull& hull_;
  Vec3 centre_;
  std::map<std::pair<int, int>, int> across_;  // the face on the other side of a directed edge
};

// How far the centre stands inside the outline of what touches the table: its distance from the nearest line
// that has all of it on one side.
double margin(const ConvexHull& hull, const Vec3& centre, const Vec3& down) {
  const Vec3 side = (std::fabs(down.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY()).cross(down).normalized();
  const Vec3 other = down.cross(side);
  double lowest = -HUGE_VAL;
  for (const Vec3& v : hull.vertices) lowest = std::max(lowest, down.dot(v));
  std::vector<Vec3> feet;
  for (const Vec3& v : hull.vertices)
    if (down.dot(v) > lowest - kTouching) feet.push_back(v - centre);
  constexpr int kDirections = 90;
  double least = HUGE_VAL;
  for (int i = 0; i < kDirections; ++i) {
    double s = 0, c = 0;
    det::sincos(2 * det::kPi * i / kDirections, &s, &c);
    const Vec3 along = c * side + s * other;
    double reach = -HUGE_VAL;
    for (const Vec3& foot : feet) reach = std::max(reach, along.dot(foot));
    least = std::min(least, reach);
  }
  return least;
}

bool likelier(const RestingFace& a, const RestingFace& b) {
  return a.share > b.share;
}

// Ends of rolling, near ones taken together by the likeliest among them.
std::vector<RestingFace> together(std::vector<RestingFace> ends) {
  std::stable_sort(ends.begin(), ends.end(), likelier);
  std::vector<RestingFace> out;
  for (const RestingFace& end : ends) {
    const auto same = std::find_if(out.begin(), out.end(),
                                   [&](const RestingFace& o) { return o.down.dot(end.down) > kSameFace; });
    if (same == out.end()) {
      out.push_back(end);
    } else {
      same->share += end.share;
    }
  }
  std::stable_sort(out.begin(), out.end(), likelier);
  return out;
}

}  // namespace

std::vector<RestingFace> resting_faces(const std::vector<Vec3>& points, const Vec3& centre_of_mass,
                                       std::size_t max_faces) {
  const ConvexHull hull = convex_hull(points);
  if (hull.vertices.size() < 4 || !(hull.solid.volume > 0) || !(hull.distance(centre_of_mass) < 0)) return {};
  const Rolling rolling(hull, centre_of_mass);
  std::vector<double> share(hull.faces.size(), 0);
  for (std::size_t f = 0; f < hull.faces.size(); ++f)
    share[static_cast<std::size_t>(rolling.end_of(static_cast<int>(f)))] +=
        solid_angle(hull, hull.faces[f].loop, centre_of_mass) / (4 * det::kPi);
  std::vector<RestingFace> ends;
  for (std::size_t f = 0; f < hull.faces.size(); ++f)
    if (share[f] > 0 && hull.faces[f].normal != Vec3::Zero())
      ends.push_back({hull.faces[f].normal, share[f]});
  const std::vector<RestingFace> all = together(std::move(ends));
  std::vector<RestingFace> out;
  for (const bool modelled : {true, false}) {
    for (const RestingFace& face : all) {
      if ((-face.down.z() > kSameFace) != modelled || (!modelled && face.share < kLeastShare)) continue;
      if (out.size() < max_faces && margin(hull, centre_of_mass, face.down) >= kMargin) out.push_back(face);
    }
  }
  if (out.empty() && !all.empty()) out.push_back(all.front());
  return out;
}

}  // namespace evograsp::assets

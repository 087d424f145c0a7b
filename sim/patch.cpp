#include "sim/patch.h"

#include <algorithm>
#include <cmath>

namespace evograsp::sim {
namespace {

constexpr int kMaxCorners = 24;
constexpr double kLateral = 2e-3;  // m: lines this far apart sideways still make one line of contact

// The part of a surface that faces a direction: a corner, the two ends of an edge, or the corners of a face
// in cyclic order. Coordinates: two in the tangent plane, the third along the normal.
struct Feature {
  std::array<Vec3, kMaxCorners> corner;
  int n = 0;

  void add(const Vec3& p) {
    if (n < kMaxCorners) corner[static_cast<std::size_t>(n++)] = p;
  }
  Vec3& operator[](int i) { return corner[static_cast<std::size_t>(i)]; }
  const Vec3& operator[](int i) const { return corner[static_cast<std::size_t>(i)]; }
};

double cross2(const Vec3& a, const Vec3& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Drops what lies inside the hull of the rest in the plane (Andrew's monotone chain); gives cyclic order.
void keep_hull(Feature& f) {
  std::sort(f.corner.begin(), f.corner.begin() + f.n, [](const Vec3& a, const Vec3& b) {
    if (a.x() != b.x()) return a.x() < b.x();
    return a.y() != b.y() ? a.y() < b.y() : a.z() < b.z();
  });
  std::array<Vec3, 2 * kMaxCorners> chain;
  int size = 0;
  const auto grow = [&](const Vec3& p, int floor) {
    while (size >= floor + 2 &&
           cross2(chain[static_cast<std::size_t>(size - 1)] - chain[static_cast<std::size_t>(size - 2)],
                  p - chain[static_cast<std::size_t>(size - 2)]) <= 1e-14)
      --size;
    chain[static_cast<std::size_t>(size++)] = p;
  };
  for (int i = 0; i < f.n; ++i) grow(f[i], 0);
  const int floor = size - 1;
  for (int i = f.n - 2; i >= 0; --i) grow(f[i], floor);
  if (size > 1) --size;  // the first point again
  f.n = std::min(size, kMaxCorners);
  std::copy_n(chain.begin(), f.n, f.corner.begin());
}

// Core points of the feature along a local direction d (unit), those no more than `slack` short of the
// extreme.
void collect_box(const Vec3& half, const Vec3& d, double slack, Feature& out) {
  const Vec3 drop = 2 * half.cwiseProduct(d.cwiseAbs());
  int steep = 0;
  for (int i = 1; i < 3; ++i)
    if (std::fabs(d[i]) > std::fabs(d[steep])) steep = i;
  const int u = (steep + 1) % 3, v = (steep + 2) % 3;
  const bool free_u = drop[u] <= slack, free_v = drop[v] <= slack;
  Vec3 p(d.x() < 0 ? -half.x() : half.x(), d.y() < 0 ? -half.y() : half.y(),
         d.z() < 0 ? -half.z() : half.z());
  out.add(p);
  if (free_u) {
    p[u] = -p[u];
    out.add(p);
  }
  if (free_v) {
    p[v] = -p[v];
    out.add(p);
  }
  if (free_u && free_v) {
    p[u] = -p[u];
    out.add(p);
  }
}

void collect_disc(const Vec3& half, const Vec3& d, double slack, Feature& out) {
  const double planar = std::sqrt(d.x() * d.x() + d.y() * d.y());
  const double z = d.z() < 0 ? -half.z() : half.z();
  if (2 * half.x() * planar <= slack) {
    out.add({half.x(), 0, z});
    out.add({0, half.x(), z});
    out.add({-half.x(), 0, z});
    out.add({0, -half.x(), z});
    return;
  }
  const Vec3 rim(half.x() * d.x() / planar, half.x() * d.y() / planar, z);
  out.add(rim);
  if (2 * half.z() * std::fabs(d.z()) <= slack) out.add({rim.x(), rim.y(), -z});
}

void collect_hull(const Shape& s, const Vec3& d, double slack, Feature& out) {
  double most = -1e300;
  for (std::size_t i = 0; i < s.x.size(); ++i)
    most = std::max(most, s.x[i] * d.x() + s.y[i] * d.y() + s.z[i] * d.z());
  for (std::size_t i = 0; i < s.x.size(); ++i)
    if (s.x[i] * d.x() + s.y[i] * d.y() + s.z[i] * d.z() >= most - slack) out.add({s.x[i], s.y[i], s.z[i]});
}

// The feature of a posed shape along world direction `n`, on the outer surface, in contact coordinates.
Feature feature_of(const Shape& s, const Pose& X, const Vec3& n, double slack, const Mat3& to_contact) {
  Feature f;
  const Vec3 d = X.rotation.transpose() * n;
  switch (s.core) {
    case Core::kPoint:
      f.add(Vec3::Zero());
      break;
    case Core::kSegment:
      f.add({0, 0, d.z() < 0 ? -s.half.z() : s.half.z()});
      if (2 * s.half.z() * std::fabs(d.z()) <= slack) f.add({0, 0, -f[0].z()});
      break;
    case Core::kBox:
      collect_box(s.half, d, slack, f);
      break;
    case Core::kDisc:
      collect_disc(s.half, d, slack, f);
      break;
    case Core::kHull:
      collect_hull(s, d, slack, f);
      break;
  }
  for (int i = 0; i < f.n; ++i) f[i] = to_contact * (X * f[i] + s.sweep * n);
  if (f.n > 2) keep_hull(f);
  return f;
}

// Height of a feature (edge or face) over a point of the plane.
double height(const Feature& f, const Vec3& p) {
  const Vec3 e = f[1] - f[0];
  if (f.n == 2) {
    const double l2 = e.x() * e.x() + e.y() * e.y();
    const double t = l2 > 0 ? ((p.x() - f[0].x()) * e.x() + (p.y() - f[0].y()) * e.y()) / l2 : 0;
    return f[0].z() + std::clamp(t, 0.0, 1.0) * e.z();
  }
  // The corner that makes the largest triangle gives the plane best.
  int far = 2;
  for (int i = 3; i < f.n; ++i)
    if (std::fabs(cross2(e, f[i] - f[0])) > std::fabs(cross2(e, f[far] - f[0]))) far = i;
  const Vec3 m = e.cross(f[far] - f[0]);
  if (!(std::fabs(m.z()) > 1e-14)) return f[0].z();
  return f[0].z() - (m.x() * (p.x() - f[0].x()) + m.y() * (p.y() - f[0].y())) / m.z();
}

// `subject` cut to the inside of the convex polygon `window` (counter-clockwise, as keep_hull leaves it).
void clip(Feature& subject, const Feature& window) {
  for (int i = 0; i < window.n && subject.n > 0; ++i) {
    const Vec3 &a = window[i], edge = window[(i + 1) % window.n] - window[i];
    Feature kept;
    const int edges = subject.n == 2 ? 1 : subject.n;  // a line has one, a polygon closes
    if (subject.n == 2 && cross2(edge, subject[0] - a) >= 0) kept.add(subject[0]);
    for (int k = 0; k < edges; ++k) {
      const Vec3 &p = subject[k], &q = subject[(k + 1) % subject.n];
      const double sp = cross2(edge, p - a), sq = cross2(edge, q - a);
      if ((sp < 0) != (sq < 0)) kept.add(p + (sp / (sp - sq)) * (q - p));
      if (sq >= 0) kept.add(q);
    }
    subject = kept;
  }
}

// Two edges: the ends of their common stretch, when they run side by side.
Feature common_stretch(const Feature& a, const Feature& b) {
  Feature out;
  Vec3 along = a[1] - a[0];
  along.z() = 0;
  const double length = std::sqrt(along.dot(along));
  if (!(length > 1e-6)) return out;
  along /= length;
  const double b0 = along.dot(b[0] - a[0]), b1 = along.dot(b[1] - a[0]);
  const double from = std::max(0.0, std::min(b0, b1)), to = std::min(length, std::max(b0, b1));
  if (!(to > from) || !(std::fabs(b1 - b0) > 1e-6)) return out;
  for (const double t : {from, to}) {
    const Vec3 on_a = a[0] + (t / length) * (a[1] - a[0]);
    const Vec3 on_b = b[0] + ((t - b0) / (b1 - b0)) * (b[1] - b[0]);
    if (std::fabs(cross2(along, on_b - on_a)) <= kLateral) out.add(on_a);
  }
  return out;
}

// The four points that span the most: the two farthest apart, then the farthest to either side.
void keep_four(Feature& f) {
  if (f.n <= kMaxPatch) return;
  const auto farthest_from = [&](const Vec3& p) {
    int best = 0;
    double most = -1;
    for (int i = 0; i < f.n; ++i) {
      const double dx = f[i].x() - p.x(), dy = f[i].y() - p.y(), d = dx * dx + dy * dy;
      if (d > most) {
        most = d;
        best = i;
      }
    }
    return best;
  };
  const int i0 = farthest_from(f[0]), i1 = farthest_from(f[i0]);
  const Vec3 line = f[i1] - f[i0];
  int left = -1, right = -1;
  double most_left = 0, most_right = 0;
  for (int i = 0; i < f.n; ++i) {
    const double side = cross2(line, f[i] - f[i0]);
    if (side > most_left) most_left = side, left = i;
    if (-side > most_right) most_right = -side, right = i;
  }
  Feature kept;
  for (const int i : {i0, i1, left, right})
    if (i >= 0) kept.add(f[i]);
  f = kept;
}

Mat3 contact_frame(const Vec3& n) {
  const Vec3 off = std::fabs(n.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY();
  Vec3 u = n.cross(off);
  u /= std::sqrt(u.dot(u));
  Mat3 to_contact;
  to_contact.row(0) = u.transpose();
  to_contact.row(1) = n.cross(u).transpose();
  to_contact.row(2) = n.transpose();
  return to_contact;
}

}  // namespace

Patch contact_patch(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const Separation& closest, double margin) {
  Patch patch;
  patch.point[0] = {closest.on_b, closest.distance};
  patch.count = 1;
  if (a.core == Core::kPoint || b.core == Core::kPoint) return patch;
  const Vec3& n = closest.normal;
  const double slack = margin - closest.distance;
  const Mat3 to_contact = contact_frame(n);
  Feature fa = feature_of(a, X_WA, -n, slack, to_contact);
  if (fa.n < 2) return patch;
  const Feature fb = feature_of(b, X_WB, n, slack, to_contact);
  if (fb.n < 2) return patch;
  Feature common;
  if (fa.n == 2 && fb.n == 2) {
    common = common_stretch(fa, fb);
  } else if (fb.n > 2) {
    common = fa;
    clip(common, fb);
  } else {
    common = fb;
    clip(common, fa);
  }
  Feature near;
  for (int i = 0; i < common.n; ++i) {
    const double gap = height(fa, common[i]) - height(fb, common[i]);
    if (gap <= margin) near.add(common[i]);
  }
  keep_four(near);
  if (near.n < 2) return patch;
  patch.count = near.n;
  for (int i = 0; i < near.n; ++i) {
    const double hb = height(fb, near[i]);
    const Vec3 p(near[i].x(), near[i].y(), hb);
    patch.point[static_cast<std::size_t>(i)] = {to_contact.transpose() * p, height(fa, near[i]) - hb};
  }
  return patch;
}

}  // namespace evograsp::sim

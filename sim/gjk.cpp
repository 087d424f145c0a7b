#include "sim/gjk.h"

#include <algorithm>
#include <cmath>

#include "sim/support.h"

namespace evograsp::sim {
namespace {

constexpr int kMaxIterations = 100;
constexpr double kTouching = 1e-24;  // m^2: closer cores have met

// Up to four points of the Minkowski difference a - b, the points of a they came from, and the weights of the
// point of their hull that is closest to the origin.
struct Simplex {
  Vec3 w[4];
  Vec3 a[4];
  double weight[4];
  int n = 0;
};

// Weights of the point of triangle (a, b, c) closest to the origin (Ericson, Real-Time Collision Detection,
// 2005, section 5.1.5: the Voronoi regions in turn).
void closest_on_triangle(const Vec3& a, const Vec3& b, const Vec3& c, double* l) {
  const Vec3 ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  l[0] = l[1] = l[2] = 0;
  if (d1 <= 0 && d2 <= 0) {
    l[0] = 1;
    return;
  }
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0 && d4 <= d3) {
    l[1] = 1;
    return;
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    l[1] = d1 > d3 ? d1 / (d1 - d3) : 0;
    l[0] = 1 - l[1];
    return;
  }
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  if (d6 >= 0 && d5 <= d6) {
    l[2] = 1;
    return;
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    l[2] = d2 > d6 ? d2 / (d2 - d6) : 0;
    l[0] = 1 - l[2];
    return;
  }
  const double va = d3 * d6 - d5 * d4;
  const double e1 = d4 - d3, e2 = d5 - d6;
  const double area = va + vb + vc;
  if ((va <= 0 && e1 >= 0 && e2 >= 0) || !(area > 0)) {
    l[2] = e1 + e2 > 0 ? std::clamp(e1 / (e1 + e2), 0.0, 1.0) : 0;
    l[1] = 1 - l[2];
    return;
  }
  l[1] = vb / area;
  l[2] = vc / area;
  l[0] = 1 - l[1] - l[2];
}

void closest_on_segment(const Vec3& a, const Vec3& b, double* l) {
  const Vec3 ab = b - a;
  const double along = -a.dot(ab), length2 = ab.dot(ab);
  l[1] = along <= 0 || !(length2 > 0) ? 0 : (along >= length2 ? 1 : along / length2);
  l[0] = 1 - l[1];
}

// The newest vertex is always part of the answer, so only its three faces are looked at.
// False when the origin is inside.
bool closest_on_tetrahedron(const Vec3* w, double* l) {
  static constexpr int kFace[3][4] = {{0, 1, 3, 2}, {1, 2, 3, 0}, {2, 0, 3, 1}};
  double best = std::numeric_limits<double>::infinity();
  for (const auto& f : kFace) {
    const Vec3 &a = w[f[0]], &b = w[f[1]], &c = w[f[2]];
    const Vec3 n = (b - a).cross(c - a);
    const double origin_side = -a.dot(n), fourth_side = (w[f[3]] - a).dot(n);
    if (origin_side * fourth_side > 0) continue;
    double t[3];
    closest_on_triangle(a, b, c, t);
    const Vec3 q = t[0] * a + t[1] * b + t[2] * c;
    const double d = q.dot(q);
    if (d < best) {
      best = d;
      l[f[0]] = t[0], l[f[1]] = t[1], l[f[2]] = t[2], l[f[3]] = 0;
    }
  }
  return best < std::numeric_limits<double>::infinity();
}

// Keeps the vertices that carry the closest point and returns it; false when the origin is inside.
bool reduce(Simplex& s, Vec3& v) {
  double l[4] = {1, 0, 0, 0};
  if (s.n == 2) closest_on_segment(s.w[0], s.w[1], l);
  if (s.n == 3) closest_on_triangle(s.w[0], s.w[1], s.w[2], l);
  if (s.n == 4 && !closest_on_tetrahedron(s.w, l)) return false;
  int kept = 0;
  v.setZero();
  for (int i = 0; i < s.n; ++i) {
    if (!(l[i] > 0)) continue;
    if (kept != i) {
      s.w[kept] = s.w[i];
      s.a[kept] = s.a[i];
    }
    s.weight[kept] = l[i];
    v += l[i] * s.w[kept];
    ++kept;
  }
  s.n = kept;
  return kept < 4;
}

// a in b's frame, so that b's supports need no rotation.
struct Relative {
  Mat3 rotation;
  Vec3 position;
};

struct Answer {
  Vec3 v;            // closest point of the Minkowski difference
  double lower = 0;  // proven distance of the cores
  bool overlap = false, bound_only = false;
};

template <Core kA, Core kB>
Answer iterate(const Shape& a, const Shape& b, const Relative& x, const Vec3& guess, double stop_above,
               double tolerance, Simplex& s) {
  Answer out;
  Vec3 v = guess;
  bool have_point = false;  // v is a point of the difference, not only a direction
  for (int i = 0; i < kMaxIterations; ++i) {
    const Vec3 da = -(x.rotation.transpose() * v);
    const Vec3 pa = x.rotation * core_support<kA>(a, da) + x.position;
    const Vec3 w = pa - core_support<kB>(b, v);
    const double vv = v.dot(v), vw = v.dot(w), length = std::sqrt(vv);
    if (vw > out.lower * length) out.lower = vw / length;
    if (out.lower > stop_above) {
      out.bound_only = true;
      break;
    }
    if (have_point) {
      if (vv - vw <= tolerance * length || vv - vw <= 1e-14 * vv) break;
      bool known = false;
      for (int k = 0; k < s.n; ++k) known = known || s.w[k] == w;
      if (known) break;
    }
    const Simplex before = s;
    s.w[s.n] = w;
    s.a[s.n] = pa;
    ++s.n;
    Vec3 next;
    const bool outside = reduce(s, next);
    if (!outside || next.dot(next) < kTouching) {
      // A separation that was proven overrules a degenerate tetrahedron.
      if (have_point && out.lower > 1e-9) {
        s = before;
        break;
      }
      out.overlap = true;
      return out;
    }
    if (have_point && next.dot(next) >= vv) {
      s = before;
      break;
    }
    v = next;
    have_point = true;
  }
  out.v = v;
  return out;
}

using Iterate = Answer (*)(const Shape&, const Shape&, const Relative&, const Vec3&, double, double,
                           Simplex&);

template <Core kA>
constexpr Iterate row(Core b) {
  switch (b) {
    case Core::kPoint:
      return iterate<kA, Core::kPoint>;
    case Core::kSegment:
      return iterate<kA, Core::kSegment>;
    case Core::kBox:
      return iterate<kA, Core::kBox>;
    case Core::kDisc:
      return iterate<kA, Core::kDisc>;
    case Core::kHull:
      break;
  }
  return iterate<kA, Core::kHull>;
}

Iterate choose(Core a, Core b) {
  switch (a) {
    case Core::kPoint:
      return row<Core::kPoint>(b);
    case Core::kSegment:
      return row<Core::kSegment>(b);
    case Core::kBox:
      return row<Core::kBox>(b);
    case Core::kDisc:
      return row<Core::kDisc>(b);
    case Core::kHull:
      break;
  }
  return row<Core::kHull>(b);
}

Vec3 first_direction(const Shape& a, const Shape& b, const Relative& x, const Mat3& r_WB, const Vec3& guess) {
  if (guess.dot(guess) > 0) return r_WB.transpose() * guess;
  const Vec3 between = x.rotation * a.centre + x.position - b.centre;
  return between.dot(between) > 1e-20 ? between : Vec3(1, 0, 0);
}

}  // namespace

Separation distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const DistanceOptions& options) {
  const Mat3 to_b = X_WB.rotation.transpose();
  const Relative x{to_b * X_WA.rotation, to_b * (X_WA.position - X_WB.position)};
  const double sweeps = a.sweep + b.sweep;
  const Vec3 guess = first_direction(a, b, x, X_WB.rotation, options.guess);
  Simplex s;
  const Answer found =
      choose(a.core, b.core)(a, b, x, guess, options.stop_above + sweeps, options.tolerance, s);
  Separation out;
  out.overlap = found.overlap;
  out.bound_only = found.bound_only;
  if (found.overlap) {
    out.distance = -sweeps;
    return out;
  }
  const double length = std::sqrt(found.v.dot(found.v));
  const Vec3 n = found.v / length;
  out.normal = X_WB.rotation * n;
  if (found.bound_only) {
    out.distance = found.lower - sweeps;
    return out;
  }
  out.distance = length - sweeps;
  Vec3 pa = Vec3::Zero();
  for (int i = 0; i < s.n; ++i) pa += s.weight[i] * s.a[i];
  out.on_a = X_WB * Vec3(pa - a.sweep * n);
  out.on_b = X_WB * Vec3(pa - found.v + b.sweep * n);
  return out;
}

}  // namespace evograsp::sim

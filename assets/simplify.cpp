#include "assets/simplify.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "assets/contained.h"

namespace evograsp::assets {
namespace {

// Many triangles at one vertex or edge take the square of their number; other surfaces many times less.
constexpr double kLeastSeconds = 20, kTrianglesPerSecond = 20e3;

// v'Av + 2b'v + c: the summed squared distances to planes.
struct Quadric {
  Mat3 a = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double c = 0;

  void add_plane(const Vec3& normal, const Vec3& on, double weight) {
    const double d = -normal.dot(on);
    a += weight * normal * normal.transpose();
    b += weight * d * normal;
    c += weight * d * d;
  }
  Quadric operator+(const Quadric& o) const { return {a + o.a, b + o.b, c + o.c}; }
  double at(const Vec3& v) const { return v.dot(a * v) + 2 * b.dot(v) + c; }
};

struct Collapse {
  double cost;
  std::uint32_t a, b;  // a < b; b goes
  std::uint32_t stamp_a, stamp_b;
  Vec3 to;
  bool operator>(const Collapse& o) const { return std::tie(cost, a, b) > std::tie(o.cost, o.a, o.b); }
};

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // low, high

class Simplifier {
 public:
  explicit Simplifier(const Mesh& mesh)
      : mesh_(mesh),
        around_(mesh.vertices.size()),
        quadric_(mesh.vertices.size()),
        stamp_(mesh.vertices.size(), 0),
        alive_(mesh.triangles.size(), true) {
    find_open_edges();
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (const std::uint32_t v : mesh_.triangles[t]) around_[v].push_back(t);
      add_quadrics(t);
    }
    for (std::uint32_t v = 0; v < around_.size(); ++v) {
      for (const std::uint32_t n : ring(v)) {
        if (n > v) propose(v, n);
      }
    }
  }

  Mesh run(std::size_t max_triangles) {
    std::size_t left = mesh_.triangles.size();
    while (left > max_triangles && !queue_.empty()) {
      const Collapse c = queue_.top();
      queue_.pop();
      if (stamp_[c.a] != c.stamp_a || stamp_[c.b] != c.stamp_b) continue;
      const std::vector<std::uint32_t> shared = shared_triangles(c.a, c.b);
      if (shared.empty() || !allowed(c, shared.size())) continue;
      apply(c, shared);
      left -= shared.size();
    }
    std::size_t out = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (alive_[t]) mesh_.triangles[out++] = mesh_.triangles[t];
    }
    mesh_.triangles.resize(out);
    weld(mesh_, 1e-9);
    return std::move(mesh_);
  }

 private:
  void add_quadrics(std::uint32_t t) {
    const Vec3 a = mesh_.corner(t, 0), cross = (mesh_.corner(t, 1) - a).cross(mesh_.corner(t, 2) - a);
    const double twice = cross.norm();
    if (!(twice > 0)) return;
    for (const std::uint32_t v : mesh_.triangles[t]) quadric_[v].add_plane(cross / twice, a, twice);
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t u = mesh_.triangles[t][k], w = mesh_.triangles[t][(k + 1) % 3];
      hold_border(u, w, cross / twice);
    }
  }

  // A plane along an open edge, square to its triangle.
  void hold_border(std::uint32_t u, std::uint32_t w, const Vec3& normal) {
    if (!std::binary_search(open_.begin(), open_.end(), Edge(std::minmax(u, w)))) return;
    const Vec3 across = (mesh_.vertices[w] - mesh_.vertices[u]).cross(normal);
    const double length = across.norm();
    if (!(length > 0)) return;
    for (const std::uint32_t v : {u, w}) {
      quadric_[v].add_plane(across / length, mesh_.vertices[u], 10 * length * length);
    }
  }

  void find_open_edges() {
    std::vector<Edge> edges;
    for (const auto& t : mesh_.triangles) {
      for (int k = 0; k < 3; ++k) edges.emplace_back(std::minmax(t[k], t[(k + 1) % 3]));
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0; i < edges.size();) {
      std::size_t j = i + 1;
      while (j < edges.size() && edges[j] == edges[i]) ++j;
      if (j == i + 1) open_.push_back(edges[i]);
      i = j;
    }
  }

  std::vector<std::uint32_t> ring(std::uint32_t v) const {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t t : around_[v]) {
      for (const std::uint32_t n : mesh_.triangles[t]) {
        if (n != v) out.push_back(n);
      }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  std::vector<std::uint32_t> shared_triangles(std::uint32_t a, std::uint32_t b) const {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t t : around_[a]) {
      const auto& tri = mesh_.triangles[t];
      if (std::find(tri.begin(), tri.end(), b) != tri.end()) out.push_back(t);
    }
    return out;
  }

  void propose(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const Quadric q = quadric_[a] + quadric_[b];
    const Vec3 middle = (mesh_.vertices[a] + mesh_.vertices[b]) / 2;
    Collapse best{HUGE_VAL, a, b, stamp_[a], stamp_[b], middle};
    std::array<Vec3, 4> places{middle, mesh_.vertices[a], mesh_.vertices[b], middle};
    const double reach = (mesh_.vertices[a] - mesh_.vertices[b]).norm();
    const double scale = q.a.trace();
    if (std::fabs(q.a.determinant()) > 1e-6 * scale * scale * scale) {
      const Vec3 optimum = q.a.inverse() * -q.b;
      if ((optimum - middle).norm() <= 2 * reach) places[3] = optimum;
    }
    for (const Vec3& p : places) {
      const double cost = std::max(0.0, q.at(p));
      if (cost < best.cost) best.cost = cost, best.to = p;
    }
    queue_.push(best);
  }

  bool allowed(const Collapse& c, std::size_t shared) const {
    const std::vector<std::uint32_t> ra = ring(c.a), rb = ring(c.b);
    std::vector<std::uint32_t> common;
    std::set_intersection(ra.begin(), ra.end(), rb.begin(), rb.end(), std::back_inserter(common));
    if (common.size() > shared) return false;  // would pinch the surface
    return keeps_sides(c.a, c.b, c.to) && keeps_sides(c.b, c.a, c.to);
  }

  // No triangle of v that survives turns by more than about 78 degrees.
  bool keeps_sides(std::uint32_t v, std::uint32_t other, const Vec3& to) const {
    for (const std::uint32_t t : around_[v]) {
      const auto& tri = mesh_.triangles[t];
      if (std::find(tri.begin(), tri.end(), other) != tri.end()) continue;
      Vec3 p[3], moved[3];
      for (int k = 0; k < 3; ++k) p[k] = mesh_.vertices[tri[k]], moved[k] = tri[k] == v ? to : p[k];
      const Vec3 before = (p[1] - p[0]).cross(p[2] - p[0]),
                 after = (moved[1] - moved[0]).cross(moved[2] - moved[0]);
      if (before.dot(after) <= 0.2 * before.norm() * after.norm()) return false;
    }
    return true;
  }

  void apply(const Collapse& c, const std::vector<std::uint32_t>& shared) {
    for (const std::uint32_t t : shared) {
      alive_[t] = false;
      for (const std::uint32_t v : mesh_.triangles[t]) {
        auto& list = around_[v];
        list.erase(std::remove(list.begin(), list.end(), t), list.end());
      }
    }
    for (const std::uint32_t t : around_[c.b]) {
      for (std::uint32_t& v : mesh_.triangles[t]) {
        if (v == c.b) v = c.a;
      }
      around_[c.a].push_back(t);
    }
    around_[c.b].clear();
    mesh_.vertices[c.a] = c.to;
    quadric_[c.a] = quadric_[c.a] + quadric_[c.b];
    ++stamp_[c.a];
    ++stamp_[c.b];
    for (const std::uint32_t n : ring(c.a)) propose(c.a, n);
  }

  Mesh mesh_;
  std::vector<std::vector<std::uint32_t>> around_;  // triangles of each vertex
  std::vector<Quadric> quadric_;
  std::vector<std::uint32_t> stamp_;  // counts a vertex's changes: older proposals are stale
  std::vector<bool> alive_;
  std::vector<Edge> open_;  // edges of one triangle, sorted
  std::priority_queue<Collapse, std::vector<Collapse>, std::greater<>> queue_;
};

}  // namespace

Mesh simplified(const Mesh& mesh, std::size_t max_triangles) {
  if (mesh.triangles.size() <= max_triangles) return mesh;
  return Simplifier(mesh).run(max_triangles);
}

Result<Mesh> contained_simplified(const Mesh& mesh, std::size_t max_triangles, double seconds) {
  if (mesh.triangles.size() <= max_triangles) return mesh;
  Containment limits;
  limits.seconds = kLeastSeconds + static_cast<double>(mesh.triangles.size()) / kTrianglesPerSecond;
  if (seconds > 0) limits.seconds = seconds;
  const Result<std::string> bytes =
      run_contained([&]() -> Result<std::string> { return encode(simplified(mesh, max_triangles)); }, limits);
  if (!bytes) return fail(bytes.error().code, "simplifying its surface " + bytes.error().message);
  return decode(*bytes);
}

}  // namespace evograsp::assets

#include "assets/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>

namespace evograsp::assets {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// Representative of each vertex: the first of those in the same grid cell.
std::vector<std::uint32_t> representatives(const std::vector<Vec3>& vertices, double cell) {
  const auto key = [&](const Vec3& v) {
    return std::array<double, 3>{std::floor(v.x() / cell + 0.5), std::floor(v.y() / cell + 0.5),
                                 std::floor(v.z() / cell + 0.5)};
  };
  std::vector<std::pair<std::array<double, 3>, std::uint32_t>> keyed;
  keyed.reserve(vertices.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) keyed.emplace_back(key(vertices[i]), i);
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> first(vertices.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    const bool same = i > 0 && keyed[i].first == keyed[i - 1].first;
    first[keyed[i].second] = same ? first[keyed[i - 1].second] : keyed[i].second;
  }
  return first;
}

bool has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - a).squaredNorm() > 1e-30;
}

void drop_twins(std::vector<Triangle>& triangles) {
  std::vector<std::pair<Triangle, std::size_t>> sorted;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Triangle t = triangles[i];  // rotated so that the smallest index leads: direction is kept
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    sorted.emplace_back(t, i);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<bool> keep(triangles.size(), true);
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].first == sorted[i - 1].first) keep[sorted[i].second] = false;
  }
  std::size_t out = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (keep[i]) triangles[out++] = triangles[i];
  }
  triangles.resize(out);
}

void drop_unused(Mesh& mesh) {
  constexpr std::uint32_t kUnused = 0xffffffff;
  std::vector<std::uint32_t> renamed(mesh.vertices.size(), kUnused);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) renamed[v] = 0;
  }
  std::uint32_t next = 0;
  for (std::uint32_t v = 0; v < renamed.size(); ++v) {
    if (renamed[v] == kUnused) continue;
    mesh.vertices[next] = mesh.vertices[v];
    renamed[v] = next++;
  }
  mesh.vertices.resize(next);
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = renamed[v];
  }
}

// One use of an undirected edge by a triangle.
struct EdgeUse {
  std::uint32_t low, high, triangle;
  bool forward;  // low to high
  bool same_edge(const EdgeUse& o) const { return low == o.low && high == o.high; }
};

std::vector<EdgeUse> edge_uses(const Mesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle, a.forward) < std::tie(b.low, b.high, b.triangle, b.forward);
  });
  return uses;
}

template <class Visit>  // visit(first, last) for each undirected edge
void for_each_edge(const std::vector<EdgeUse>& uses, Visit visit) {
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t j = i + 1;
    while (j < uses.size() && uses[j].same_edge(uses[i])) ++j;
    visit(i, j);
    i = j;
  }
}

struct Link {
  std::uint32_t triangle;
  bool agrees;
};

std::vector<std::vector<Link>> neighbours(const Mesh& mesh) {
  const std::vector<EdgeUse> uses = edge_uses(mesh);
  std::vector<std::vector<Link>> links(mesh.triangles.size());
  for_each_edge(uses, [&](std::size_t i, std::size_t j) {
    if (j - i != 2) return;
    const bool agrees = uses[i].forward != uses[i + 1].forward;
    links[uses[i].triangle].push_back({uses[i + 1].triangle, agrees});
    links[uses[i + 1].triangle].push_back({uses[i].triangle, agrees});
  });
  return links;
}

void flip(Triangle& t) {
  std::swap(t[1], t[2]);
}

// Triangles of each shell (connected over edges shared by two), each turned to agree with its first.
std::vector<std::vector<std::uint32_t>> agreeing_shells(Mesh& mesh) {
  const auto links = neighbours(mesh);
  std::vector<char> state(mesh.triangles.size(), 0);  // 1: as is, 2: flipped
  std::vector<std::vector<std::uint32_t>> shells;
  for (std::uint32_t start = 0; start < mesh.triangles.size(); ++start) {
    if (state[start] != 0) continue;
    std::vector<std::uint32_t> shell{start};
    state[start] = 1;
    for (std::size_t i = 0; i < shell.size(); ++i) {
      for (const Link& link : links[shell[i]]) {
        if (state[link.triangle] != 0) continue;
        state[link.triangle] = link.agrees ? state[shell[i]] : static_cast<char>(3 - state[shell[i]]);
        shell.push_back(link.triangle);
      }
    }
    shells.push_back(std::move(shell));
  }
  for (std::uint32_t t = 0; t < state.size(); ++t) {
    if (state[t] == 2) flip(mesh.triangles[t]);
  }
  return shells;
}

}  // namespace

void weld(Mesh& mesh, double tolerance) {
  const std::vector<std::uint32_t> first = representatives(mesh.vertices, tolerance);
  std::size_t out = 0;
  for (const Triangle& t : mesh.triangles) {
    const Triangle n{first[t[0]], first[t[1]], first[t[2]]};
    if (n[0] == n[1] || n[1] == n[2] || n[0] == n[2]) continue;
    if (!has_area(mesh.vertices[n[0]], mesh.vertices[n[1]], mesh.vertices[n[2]])) continue;
    mesh.triangles[out++] = n;
  }
  mesh.triangles.resize(out);
  drop_twins(mesh.triangles);
  drop_unused(mesh);
}

void orient_outward(Mesh& mesh) {
  const auto shells = agreeing_shells(mesh);
  struct Shell {
    double volume = 0;
    Bounds box;
  };
  std::vector<Shell> facts;
  for (const auto& shell : shells) {
    Shell fact;
    fact.box = {Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL)};
    const Vec3 origin = mesh.corner(shell[0], 0);
    for (const std::uint32_t t : shell) {
      const Vec3 a = mesh.corner(t, 0) - origin, b = mesh.corner(t, 1) - origin,
                 c = mesh.corner(t, 2) - origin;
      fact.volume += a.dot(b.cross(c)) / 6;
      for (int k = 0; k < 3; ++k) {
        fact.box.low = fact.box.low.cwiseMin(mesh.corner(t, k));
        fact.box.high = fact.box.high.cwiseMax(mesh.corner(t, k));
      }
    }
    facts.push_back(fact);
  }
  const auto within_another = [&](std::size_t i) {
    for (std::size_t j = 0; j < facts.size(); ++j) {
      if (j != i && (facts[i].box.low.array() > facts[j].box.low.array()).all() &&
          (facts[i].box.high.array() < facts[j].box.high.array()).all()) {
        return true;
      }
    }
    return false;
  };
  constexpr std::size_t kMaxShells = 2000;  // a soup of more loose pieces has no cavities worth finding
  for (std::size_t i = 0; i < shells.size(); ++i) {
    if (facts[i].volume >= 0 || (shells.size() <= kMaxShells && within_another(i))) continue;
    for (const std::uint32_t t : shells[i]) flip(mesh.triangles[t]);
  }
}

std::size_t open_edges(const Mesh& mesh) {
  const std::vector<EdgeUse> uses = edge_uses(mesh);
  std::size_t open = 0;
  for_each_edge(uses, [&](std::size_t i, std::size_t j) {
    int balance = 0;
    for (std::size_t k = i; k < j; ++k) balance += uses[k].forward ? 1 : -1;
    open += balance != 0;
  });
  return open;
}

Solid solid_of(const Mesh& mesh) {
  Solid s;
  if (mesh.vertices.empty()) return s;
  // About the mean vertex, where cancellation is least.
  Vec3 mean = Vec3::Zero();
  for (const Vec3& v : mesh.vertices) mean += v;
  mean /= static_cast<double>(mesh.vertices.size());
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0) - mean, b = mesh.corner(t, 1) - mean, c = mesh.corner(t, 2) - mean;
    const double six = a.dot(b.cross(c));  // six times the signed volume of the tetrahedron to the mean
    const Vec3 sum = a + b + c;
    s.volume += six / 6;
    first += six / 24 * sum;
    second += six / 120 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  if (!(s.volume > 0)) return {};
  const Vec3 centre = first / s.volume;
  const Mat3 moment = second - s.volume * centre * centre.transpose();
  s.inertia = moment.trace() * Mat3::Identity() - moment;
  s.centre = mean + centre;
  return s;
}

double area_of(const Mesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0);
    area += (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).norm() / 2;
  }
  return area;
}

Bounds bounds_of(const Mesh& mesh) {
  Bounds b{Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL)};
  for (const Vec3& v : mesh.vertices) {
    b.low = b.low.cwiseMin(v);
    b.high = b.high.cwiseMax(v);
  }
  return b;
}

proto::TriangleMesh visual_of(const Mesh& mesh) {
  proto::TriangleMesh out;
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) out.add_xyz(static_cast<float>(v[k]));
  }
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) out.add_triangle(v);
  }
  return out;
}

std::string encode(const Mesh& mesh) {
  const std::uint64_t counts[2] = {mesh.vertices.size(), mesh.triangles.size()};
  std::string out(reinterpret_cast<const char*>(counts), sizeof counts);
  for (const Vec3& v : mesh.vertices) out.append(reinterpret_cast<const char*>(v.data()), 3 * sizeof(double));
  for (const Triangle& t : mesh.triangles) out.append(reinterpret_cast<const char*>(t.data()), sizeof t);
  return out;
}

Result<Mesh> decode(std::string_view bytes) {
  std::uint64_t counts[2];
  if (bytes.size() < sizeof counts) return fail(ErrorCode::kInternal, "mesh bytes: cut short");
  std::memcpy(counts, bytes.data(), sizeof counts);
  bytes.remove_prefix(sizeof counts);
  constexpr std::size_t kVertex = 3 * sizeof(double), kTriangle = sizeof(Triangle);
  if (counts[0] > bytes.size() / kVertex || counts[1] > bytes.size() / kTriangle ||
      bytes.size() != counts[0] * kVertex + counts[1] * kTriangle) {
    return fail(ErrorCode::kInternal, "mesh bytes: counts do not match the length");
  }
  Mesh mesh;
  mesh.vertices.resize(counts[0]);
  mesh.triangles.resize(counts[1]);
  for (std::size_t i = 0; i < counts[0]; ++i)
    std::memcpy(mesh.vertices[i].data(), bytes.data() + i * kVertex, kVertex);
  if (counts[1] > 0)
    std::memcpy(mesh.triangles.data(), bytes.data() + counts[0] * kVertex, counts[1] * kTriangle);
  for (const Triangle& t : mesh.triangles) {
    if (std::max({t[0], t[1], t[2]}) >= counts[0])
      return fail(ErrorCode::kInternal, "mesh bytes: index out of range");
  }
  return mesh;
}

}  // namespace evograsp::assets

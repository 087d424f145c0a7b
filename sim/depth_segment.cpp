// segment_clicked: the pixels of the clicked object.
#include <algorithm>
#include <cmath>

#include "common/random.h"
#include "sim/depth_image.h"

namespace evograsp::sim {
namespace {

constexpr double kAboveSupport = 0.008;    // m: nearer to the plane is the plane
constexpr double kPlaneThickness = 0.006;  // m: within this a point supports a plane
constexpr int kPlaneTries = 300;
constexpr std::size_t kPlaneSamples = 2000;

struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
  double distance(const Vec3& p) const { return std::fabs(normal.dot(p) - offset); }
};

// Points of a window of a third of the image around the click: enough to see what the object stands on.
std::vector<Vec3> points_around(const DepthImage& image, int u, int v) {
  const int reach_u = image.width() / 3, reach_v = image.height() / 3;
  const double area = 4.0 * reach_u * reach_v;
  const int step = std::max(1, static_cast<int>(std::sqrt(area / static_cast<double>(kPlaneSamples))));
  std::vector<Vec3> points;
  for (int y = std::max(0, v - reach_v); y < std::min(image.height(), v + reach_v); y += step)
    for (int x = std::max(0, u - reach_u); x < std::min(image.width(), u + reach_u); x += step)
      if (const std::optional<double> z = image.reading(x, y))
        points.push_back(image.point({static_cast<double>(x), static_cast<double>(y)}, *z));
  return points;
}

// The plane through three points that most others support; nothing when few do.
std::optional<Plane> main_plane(const std::vector<Vec3>& points) {
  if (points.size() < 30) return std::nullopt;
  Random random(hash_key(0, Purpose::kSensorNoise, 0, 1));
  const auto count = static_cast<std::uint32_t>(points.size());
  Plane best;
  std::size_t most = 0;
  for (int i = 0; i < kPlaneTries; ++i) {
    const Vec3& a = points[random.below(count)];
    const Vec3& b = points[random.below(count)];
    const Vec3& c = points[random.below(count)];
    const Vec3 n = (b - a).cross(c - a);
    const double size = std::sqrt(n.dot(n));
    if (size < 1e-5) continue;
    const Plane plane{n / size, n.dot(a) / size};
    std::size_t support = 0;
    for (const Vec3& p : points) support += plane.distance(p) < kPlaneThickness ? 1 : 0;
    if (support > most) most = support, best = plane;
  }
  if (most < points.size() / 5) return std::nullopt;
  return best;
}

// Neighbouring readings of one surface differ by less than this: 1 cm, or 1.5 % of the distance.
double largest_step(double z) {
  return std::max(0.01, 0.015 * z);
}

}  // namespace

std::optional<Segment> segment_clicked(const DepthImage& image, int u, int v) {
  const std::optional<double> seed = image.reading(u, v);
  if (!seed) return std::nullopt;
  const std::optional<Plane> support = main_plane(points_around(image, u, v));
  const auto stands_out = [&](int x, int y, double z) {
    return !support || support->distance(image.point({static_cast<double>(x), static_cast<double>(y)}, z)) >
                           kAboveSupport;
  };
  if (!stands_out(u, v, *seed)) return std::nullopt;

  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width()) +
           static_cast<std::size_t>(x);
  };
  std::vector<std::uint8_t> seen(
      static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.height()), 0);
  std::vector<std::pair<int, int>> open = {{u, v}};
  seen[index(u, v)] = 1;
  Segment out{u, v, u, v, 0};
  while (!open.empty()) {
    const auto [x, y] = open.back();
    open.pop_back();
    ++out.pixels;
    out.left = std::min(out.left, x), out.right = std::max(out.right, x);
    out.top = std::min(out.top, y), out.bottom = std::max(out.bottom, y);
    const double z = *image.reading(x, y);
    for (const auto& [nx, ny] : {std::pair{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}}) {
      const std::optional<double> next = image.reading(nx, ny);
      if (!next || seen[index(nx, ny)] || std::fabs(*next - z) > largest_step(z) ||
          !stands_out(nx, ny, *next))
        continue;
      seen[index(nx, ny)] = 1;
      open.emplace_back(nx, ny);
    }
  }
  if (out.pixels < 30 || out.pixels > seen.size() / 4) return std::nullopt;
  return out;
}

}  // namespace evograsp::sim

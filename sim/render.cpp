#include "sim/render.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "common/det_math.h"
#include "common/random.h"

namespace evograsp::sim {
namespace {

constexpr double kOffset = 2e-5;    // m: shadow rays start this far off a surface
constexpr double kSkyReach = 0.30;  // m: what is farther does not darken the sky
constexpr double kExposure = 0.78;
constexpr double kLightRadius = 0.30;  // m
const Vec3 kLight(-0.15, -1.05, 1.75);
const Vec3 kLightColour(1.00, 0.96, 0.90);
const Vec3 kSkyColour(0.86, 0.92, 1.00);
const Vec3 kBackdropLow(0.80, 0.82, 0.85);
const Vec3 kBackdropHigh(0.93, 0.95, 0.97);
const Vec3 kTableColour(0.47, 0.46, 0.44);
const Vec3 kLineColour(0.30, 0.31, 0.33);

Vec3 unit(const Vec3& v) {
  return v / std::sqrt(v.dot(v));
}
Vec3 mix(const Vec3& a, const Vec3& b, double t) {
  return a + (b - a) * t;
}
double clamp01(double x) {
  return x < 0 ? 0 : x > 1 ? 1 : x;
}
double smooth(double from, double to, double x) {
  const double t = clamp01((x - from) / (to - from));
  return t * t * (3 - 2 * t);
}
double fraction(double x) {
  return x - std::floor(x);
}
double power5(double x) {
  return x * x * x * x * x;
}

struct Basis {
  Vec3 a, b;
  explicit Basis(const Vec3& n) {
    a = unit(std::fabs(n.x()) < 0.7 ? Vec3(Vec3::UnitX().cross(n)) : Vec3(Vec3::UnitY().cross(n)));
    b = n.cross(a);
  }
};

// Points of the unit square that fill it evenly: the R2 sequence, shifted at random from pixel to pixel so
// that what is left of the error is grain, not bands.
struct Samples {
  double shift_a, shift_b;
  Samples(int u, int v) {
    Random random(
        hash_key(0, Purpose::kSensorNoise, static_cast<std::uint64_t>(u), static_cast<std::uint64_t>(v)));
    shift_a = random.uniform();
    shift_b = random.uniform();
  }
  void get(int index, double* a, double* b) const {
    *a = fraction(shift_a + index * 0.7548776662466927);
    *b = fraction(shift_b + index * 0.5698402909980532);
  }
};

class Tracer {
 public:
  Tracer(const RenderScene& scene, const Camera& camera, const RenderOptions& options)
      : scene_(scene), camera_(camera), options_(options) {
    auto solid = std::make_shared<std::vector<RayBody>>();
    for (const RenderItem& item : scene.solid) solid->push_back(item.body), solid_pose_.push_back(item.X_WB);
    auto glass = std::make_shared<std::vector<RayBody>>();
    for (const RenderItem& item : scene.glass) glass->push_back(item.body), glass_pose_.push_back(item.X_WB);
    solid_ = RayCaster(std::move(solid), scene.table_half);
    glass_ = RayCaster(std::move(glass), 0);
  }

  ColourImage run() const {
    ColourImage image(camera_.width(), camera_.height());
    std::atomic<int> next_row{0};
    const auto work = [&] {
      const PosedScene solid(solid_, solid_pose_, {}), glass(glass_, glass_pose_, {});
      for (int v = next_row++; v < camera_.height(); v = next_row++)
        for (int u = 0; u < camera_.width(); ++u) encode(pixel(solid, glass, u, v), image.pixel(u, v));
    };
    const int threads =
        options_.threads > 0 ? options_.threads : static_cast<int>(std::thread::hardware_concurrency());
    std::vector<std::thread> helpers;
    for (int i = 1; i < std::min(threads, 64); ++i) helpers.emplace_back(work);
    work();
    for (std::thread& helper : helpers) helper.join();
    return image;
  }

 private:
  static void encode(const Vec3& light, std::uint8_t* rgb) {
    for (int k = 0; k < 3; ++k) {
      const double x = kExposure * std::max(0.0, light[k]);
      // A filmic curve: a toe for depth, a shoulder that keeps highlights from clipping (Narkowicz's fit of
      // the ACES reference transform, 2015).
      const double toned = clamp01(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14));
      const double coded = toned > 0 ? det::exp(det::log(toned) / 2.2) : 0;
      rgb[k] = static_cast<std::uint8_t>(std::floor(255 * coded + 0.5));
    }
  }

  Vec3 pixel(const PosedScene& solid, const PosedScene& glass, int u, int v) const {
    const int n = options_.supersampling;
    const Samples samples(u, v);
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < n * n; ++i) {
      const int row = i / n, column = i % n;
      const Ray ray = camera_.ray({u + (column + 0.5) / n - 0.5, v + (row + 0.5) / n - 0.5});
      const Hit hit = solid.cast(ray, camera_.near(), camera_.far());
      Vec3 colour = hit.body == kNothing ? backdrop(ray) : shade(solid, ray, hit, samples, i);
      if (!scene_.glass.empty()) colour = through_glass(glass, ray, hit.t, colour);
      sum += colour;
    }
    return sum / (n * n);
  }

  static Vec3 backdrop(const Ray& ray) {
    const double up = unit(ray.direction).z();
    return mix(kBackdropLow, kBackdropHigh, smooth(-0.6, 0.4, up));
  }

  // A grid of lines every 5 cm, stronger every 10; lines thinner than a ray's footprint fade instead of
  // flickering.
  Vec3 table_colour(const Vec3& p, double footprint) const {
    const auto line = [&](double x, double spacing, double half) {
      const double off = std::fabs(x - spacing * std::floor(x / spacing + 0.5));
      return (1 - smooth(half - footprint / 2, half + footprint / 2, off)) *
             std::min(1.0, 2 * half / footprint);
    };
    const double fine = std::max(line(p.x(), 0.05, 0.0005), line(p.y(), 0.05, 0.0005));
    const double bold = std::max(line(p.x(), 0.10, 0.0009), line(p.y(), 0.10, 0.0009));
    return mix(kTableColour, kLineColour, std::max(0.40 * fine, 0.75 * bold));
  }

  Vec3 shade(const PosedScene& scene, const Ray& ray, const Hit& hit, const Samples& samples, int sub) const {
    const Vec3 p = ray.at(hit.t);
    const Vec3 view = -unit(ray.direction);
    Material material;
    if (hit.body == kTable) {
      const double footprint = hit.t / camera_.fx() / std::max(0.15, view.z());
      material.colour = table_colour(p, footprint);
      material.gloss = 0.05;
    } else {
      material = scene_.solid[static_cast<std::size_t>(hit.body)].material;
    }
    const Vec3 flat = scene.normal(ray, hit);
    const Vec3 n = material.bevel_m > 0 ? scene.normal(ray, hit, material.bevel_m) : flat;
    const Vec3 from = p + kOffset * (1 + hit.t) * flat;

    double lit = 0, sky = 0;
    const Basis around(flat), across(unit(kLight - p));
    for (int k = 0; k < options_.light_samples; ++k) {
      double a = 0, b = 0;
      samples.get(sub * options_.light_samples + k, &a, &b);
      double s = 0, c = 0;
      det::sincos(2 * det::kPi * a, &s, &c);
      const double r = std::sqrt(b);
      const Vec3 to = kLight + kLightRadius * r * (c * across.a + s * across.b) - from;
      if (flat.dot(to) > 0 && n.dot(to) > 0 && !scene.blocked({from, to}, 0, 1)) lit += 1;
      const Vec3 up = r * (c * around.a + s * around.b) + std::sqrt(1 - b) * flat;
      const Hit near = scene.cast({from, up}, 0, kSkyReach);
      sky += near.body == kNothing ? 1 : 0.75 * near.t / kSkyReach;
    }
    lit /= options_.light_samples, sky /= options_.light_samples;

    const Vec3 l = unit(kLight - p), half = unit(l + view);
    const double facing = std::max(0.0, n.dot(l));
    const double shine = std::max(0.0, n.dot(half));
    double highlight = shine;
    for (int k = 0; k < 5; ++k) highlight *= highlight;  // to the power 32
    const double rim = 0.03 + 0.5 * material.gloss * power5(1 - clamp01(n.dot(view)));
    const Vec3 diffuse = material.colour.cwiseProduct(1.15 * lit * facing * kLightColour +
                                                      sky * (0.42 + 0.14 * n.z()) * kSkyColour);
    return diffuse + (0.9 * material.gloss * highlight * lit * facing) * kLightColour +
           (rim * sky) * kSkyColour;
  }

  Vec3 through_glass(const PosedScene& glass, const Ray& ray, double solid_t, Vec3 colour) const {
    // Nearest layers last: gather front to back, blend back to front.
    Hit layers[8];
    int count = 0;
    double from = camera_.near();
    for (; count < 8; ++count) {
      layers[count] = glass.cast(ray, from, camera_.far());
      if (layers[count].body == kNothing) break;
      from = layers[count].t + 1e-4;
    }
    for (int k = count - 1; k >= 0; --k) {
      const Material& material = scene_.glass[static_cast<std::size_t>(layers[k].body)].material;
      const Vec3 n = glass.normal(ray, layers[k]);
      const double facing = clamp01(-n.dot(unit(ray.direction)));
      const bool hidden = layers[k].t > solid_t;
      const double opacity = material.opacity * (1 + 0.5 * (1 - facing)) * (hidden ? 0.45 : 1);
      colour = mix(colour, material.colour * (0.75 + 0.35 * facing), std::min(1.0, opacity));
    }
    return colour;
  }

  const RenderScene& scene_;
  const Camera& camera_;
  const RenderOptions& options_;
  RayCaster solid_, glass_;
  std::vector<Pose> solid_pose_, glass_pose_;
};

}  // namespace

ColourImage render(const RenderScene& scene, const Camera& camera, const RenderOptions& options) {
  return Tracer(scene, camera, options).run();
}

GreyImage render_depth(const PosedScene& scene, const Camera& camera, double units_per_metre) {
  GreyImage image{camera.width(), camera.height(), {}};
  image.value.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const Hit hit =
          scene.cast(camera.ray({static_cast<double>(u), static_cast<double>(v)}), 0, camera.far());
      const double value = std::floor(hit.t * units_per_metre + 0.5);
      image.value.push_back(hit.body == kNothing || value > 65535 ? std::uint16_t{0}
                                                                  : static_cast<std::uint16_t>(value));
    }
  return image;
}

}  // namespace evograsp::sim

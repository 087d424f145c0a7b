#include "sim/kinect_noise.h"

#include <cmath>

#include "common/det_math.h"

namespace evograsp::sim {
namespace {

constexpr double kBaseline = 0.075;  // m, between projector and camera
constexpr double kSubPixels = 8;     // disparity steps a pixel

}  // namespace

double draw_normal(Random& random) {
  const double a = random.uniform();
  const double b = random.uniform();
  return std::sqrt(-2 * det::log(1 - a)) * det::cos(2 * det::kPi * b);
}

double noisy_nothing(Random& random, double far_m) {
  random.next(), random.next(), random.next();
  return far_m;
}

double noisy_depth(const proto::KinectNoise& noise, const Camera& camera, const Ray& ray,
                   const Vec3& normal_W, double z, Random& random) {
  const double normal = draw_normal(random);
  const double luck = random.uniform();
  const double along = std::fabs(normal_W.dot(ray.direction)) / std::sqrt(ray.direction.dot(ray.direction));
  if (luck < noise.dropout() || along < det::cos(noise.dropout_angle())) return camera.far();
  const double sigma = 0.0012 + noise.axial() * (z - 0.4) * (z - 0.4);
  double reading = z + sigma * normal;
  if (noise.quantise() && reading > 0) {
    const double steps = std::floor(kSubPixels * kBaseline * camera.fx() / reading + 0.5);
    if (!(steps >= 1)) return camera.far();
    reading = kSubPixels * kBaseline * camera.fx() / steps;
  }
  return reading;
}

}  // namespace evograsp::sim

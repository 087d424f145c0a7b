#include "sim/view_features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/view_features.h"

namespace evograsp::sim {
namespace {

constexpr double kAboveTable = 0.006;  // m: lower points are the table's
constexpr double kReach = 0.15;        // m about the click: farther points are other objects'
constexpr double kTall = 0.1;          // m: height that reads 1
constexpr double kWide = 0.05;         // m: spread that reads 1
constexpr double kRound = 1e-4;        // m^2: keeps the axis of a small spot at rest
constexpr double kMost = 10;           // features stay within +-this

struct Moments {
  double weight = 0, top = 0;
  Vec3 mean = Vec3::Zero();
  double xx = 0, yy = 0, xy = 0;  // covariance
};

struct WeightedPoint {
  Vec3 at;
  double weight;
};

std::vector<WeightedPoint> object_points(const proto::CameraConfig& config, const SampledView& view) {
  const Camera& camera = *view.camera;
  const int columns = static_cast<int>(config.columns()), rows = static_cast<int>(config.rows());
  std::vector<WeightedPoint> points;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const auto i = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                     static_cast<std::size_t>(column);
      if (i >= view.depth.size() || !(view.depth[i] < 1)) continue;  // no return
      const double z = camera.near() + static_cast<double>(view.depth[i]) * (camera.far() - camera.near());
      const Pixel pixel{view.centre.u + ((column + 0.5) / columns - 0.5) * view.width,
                        view.centre.v + ((row + 0.5) / rows - 0.5) * view.height};
      const Vec3 p = camera.ray(pixel).at(z);
      const Vec3 from_click = p - view.point;
      if (p.z() >= kAboveTable && from_click.dot(from_click) <= kReach * kReach) points.push_back({p, z * z});
    }
  if (points.empty()) points.push_back({view.point, 1});
  return points;
}

Moments moments(const std::vector<WeightedPoint>& points) {
  Moments m;
  for (const WeightedPoint& p : points) {
    m.weight += p.weight;
    m.mean += p.weight * p.at;
    m.top = std::max(m.top, p.at.z());
  }
  m.mean /= m.weight;
  for (const WeightedPoint& p : points) {
    const Vec3 d = p.at - m.mean;
    const double w = p.weight / m.weight;
    m.xx += w * d.x() * d.x();
    m.yy += w * d.y() * d.y();
    m.xy += w * d.x() * d.y();
  }
  return m;
}

float limited(double value) {
  return std::isfinite(value) ? static_cast<float>(std::clamp(value, -kMost, kMost)) : 0.0f;
}

// Of the main axis: twice its angle, times how long the object is. The two numbers of AXIS.
std::array<float, 2> axis_of(const Moments& m) {
  const double sum = m.xx + m.yy + kRound;
  return {limited((m.xx - m.yy) / sum), limited(2 * m.xy / sum)};
}

// From cosine and sine of twice the main axis's angle (and their length, which does not matter): half angles
// by square roots, which round alike everywhere.
Mat3 across(double cos_twice, double sin_twice) {
  const double length = std::sqrt(cos_twice * cos_twice + sin_twice * sin_twice);
  if (!(length > 1e-6)) return Mat3::Identity();
  const double c = std::clamp(-cos_twice / length, -1.0, 1.0);  // across is a right angle further
  const double cosine = std::sqrt((1 + c) / 2), sine = std::copysign(std::sqrt((1 - c) / 2), -sin_twice);
  Mat3 turn;
  turn << cosine, -sine, 0, sine, cosine, 0, 0, 0, 1;
  return turn;
}

void append(const Vec3& v, std::vector<float>& out) {
  for (int i = 0; i < 3; ++i) out.push_back(limited(v[i]));
}

}  // namespace

std::vector<float> view_features(const proto::CameraConfig& config, const SampledView& view) {
  std::vector<float> out;
  if (config.feature_size() == 0) return out;
  const Moments m = moments(object_points(config, view));
  const double sum = m.xx + m.yy, difference = m.xx - m.yy;
  const double split = std::sqrt(difference * difference + 4 * m.xy * m.xy);
  const std::array<float, 2> axis = axis_of(m);
  const Mat3 to_frame =
      config.object_frame() ? Mat3(across(axis[0], axis[1]).transpose()) : Mat3(Mat3::Identity());
  const auto about_anchor = [&](const Vec3& p) -> Vec3 {
    return (to_frame * Vec3(p - view.anchor)).cwiseQuotient(view.unit);
  };
  for (const int feature : config.feature()) {
    switch (feature) {
      case proto::CENTROID:
        append(about_anchor(m.mean), out);
        break;
      case proto::SIZE:
        append(Vec3(m.top / kTall, std::sqrt((sum + split) / 2) / kWide,
                    std::sqrt(std::max(0.0, sum - split) / 2) / kWide),
               out);
        break;
      case proto::AXIS:
        out.insert(out.end(), axis.begin(), axis.end());
        break;
      case proto::POINT:
        append(about_anchor(view.point), out);
        break;
      default:
        break;
    }
  }
  return out;
}

Vec3 object_anchor(const proto::CameraConfig& config, const SampledView& view, bool bounding_box) {
  const Moments m = moments(object_points(config, view));
  const Vec3 eye = view.camera->pose().position;
  const Vec3 middle = bounding_box ? Vec3(view.camera->ray(view.centre).at(1)) : m.mean;
  const double drop = eye.z() - middle.z();
  if (!(drop > 1e-3 * (eye - middle).norm())) return view.anchor;
  return eye + (middle - eye) * ((eye.z() - m.top / 2) / drop);
}

Mat3 pose_frame(const proto::CameraConfig& config, std::span<const float> features) {
  if (!config.object_frame()) return Mat3::Identity();
  std::size_t at = 0;
  for (const int feature : config.feature()) {
    if (feature == proto::AXIS && at + 2 <= features.size())
      return across(static_cast<double>(features[at]), static_cast<double>(features[at + 1]));
    at += feature_size(static_cast<proto::ViewFeature>(feature));
  }
  return Mat3::Identity();
}

Vec3 workspace_unit(const proto::GraspConfig& grasp, bool bounding_box) {
  if (bounding_box)
    return grasp.has_workspace_box_half() ? from_proto(grasp.workspace_box_half()) : Vec3::Constant(0.15);
  return grasp.has_workspace_half() ? from_proto(grasp.workspace_half()) : Vec3(0.3, 0.3, 0.125);
}

}  // namespace evograsp::sim

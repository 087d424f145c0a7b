#include "sim/depth_image.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "sim/depth.h"
#include "sim/view_features.h"

namespace evograsp::sim {
namespace {

constexpr double kMinDistance = -100;  // mm, m of the registered Kinect's equations
constexpr double kScale = 0.0021;      // s of the same

// Objects in training turn a surface to the camera that stands about this much nearer than the table's
// centre.
constexpr double kSurfaceAboveTable = 0.06;  // m

bool positive(double x) {
  return std::isfinite(x) && x > 0;
}

}  // namespace

Vec3 registered_kinect_point(double i, double j, double z_mm, int w, int h) {
  const double reach = (z_mm + kMinDistance) * kScale;
  const double aspect = static_cast<double>(w) / h;
  return Vec3((i - w / 2.0) * reach * aspect, (j - h / 2.0) * reach, z_mm) / 1000;
}

Result<DepthImage> DepthImage::create(const GreyImage& image, const ImageCamera& camera) {
  if (image.width < 1 || image.height < 1) return fail(ErrorCode::kInvalid, "depth image: no pixels");
  if (!positive(camera.fx) || !positive(camera.fy) || !std::isfinite(camera.cx) || !std::isfinite(camera.cy))
    return fail(ErrorCode::kInvalid, "depth image: fx and fy must be positive, cx and cy finite");
  if (!positive(camera.units_per_metre) || camera.units_per_metre > 1e6)
    return fail(ErrorCode::kInvalid, "depth image: units_per_metre must lie above 0 and up to 1e6");
  DepthImage out;
  out.camera_ = camera;
  out.width_ = image.width, out.height_ = image.height;
  out.metres_.reserve(image.value.size());
  for (const std::uint16_t value : image.value)
    out.metres_.push_back(value == camera.invalid ? 0.f : static_cast<float>(value / camera.units_per_metre));
  return out;
}

std::optional<double> DepthImage::reading(int u, int v) const {
  if (u < 0 || v < 0 || u >= width_ || v >= height_) return std::nullopt;
  const float z =
      metres_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)];
  if (z > 0) return z;
  return std::nullopt;
}

std::optional<double> DepthImage::filled(int u, int v, bool nearest) const {
  if (const std::optional<double> z = reading(u, v)) return z;
  if (u < 0 || v < 0 || u >= width_ || v >= height_) return std::nullopt;
  for (int r = 1; r <= kHoleReach; ++r) {
    std::optional<double> best;
    const auto consider = [&](int x, int y) {
      const std::optional<double> z = reading(x, y);
      if (z && (!best || (nearest ? *z < *best : *z > *best))) best = z;
    };
    for (int k = -r; k <= r; ++k)
      consider(u + k, v - r), consider(u + k, v + r), consider(u - r, v + k), consider(u + r, v + k);
    if (best) return best;
  }
  return std::nullopt;
}

Vec3 DepthImage::point(const Pixel& pixel, double z) const {
  if (camera_.registered_kinect) return registered_kinect_point(pixel.u, pixel.v, 1000 * z, width_, height_);
  return {(pixel.u - camera_.cx) / camera_.fx * z, (pixel.v - camera_.cy) / camera_.fy * z, z};
}

Pixel DepthImage::pixel_of(double a, double b, double z) const {
  if (!camera_.registered_kinect) return {camera_.cx + a * camera_.fx, camera_.cy + b * camera_.fy};
  const double aspect = static_cast<double>(width_) / height_;
  const double reach = std::max(1.0, 1000 * z + kMinDistance) * kScale;
  return {width_ / 2.0 + a * 1000 * z / (reach * aspect), height_ / 2.0 + b * 1000 * z / reach};
}

Result<Info> look_at_recording(const DepthImage& image, const proto::CameraConfig& config,
                               const Camera& training, const proto::GraspConfig& grasp, int u, int v,
                               const RecordedOptions& options) {
  if (u < 0 || v < 0 || u >= image.width() || v >= image.height())
    return fail(ErrorCode::kUsage, "the click (" + std::to_string(u) + ", " + std::to_string(v) +
                                       ") lies outside the " + std::to_string(image.width()) + " x " +
                                       std::to_string(image.height()) + " image");
  const std::optional<double> under_click = image.filled(u, v, true);
  if (!under_click)
    return fail(ErrorCode::kInvalid,
                "no depth reading within " + std::to_string(kHoleReach) + " pixels of the click");
  const Vec3 clicked = image.point({static_cast<double>(u), static_cast<double>(v)}, *under_click);

  const std::optional<Segment> segment = segment_clicked(image, u, v);
  Pixel centre{static_cast<double>(u), static_cast<double>(v)};
  if (segment && options.centre_on_object) centre = segment->centre();
  const int cu = static_cast<int>(std::floor(centre.u + 0.5)),
            cv = static_cast<int>(std::floor(centre.v + 0.5));
  const double z = image.filled(cu, cv, true).value_or(*under_click);
  const Vec3 surface = image.point(centre, z);
  const bool move = options.bounding_box && options.at_training_distance;
  const double home = training.depth(Vec3::Zero()) - kSurfaceAboveTable;
  const double scale = move ? home / z : 1;  // apparent size at the training distance over the recorded one

  Info info;
  // Tangents of the window's centre, and of one training pixel.
  const double a0 =
      options.bounding_box ? surface.x() / z : (training.width() / 2.0 - 0.5 - training.cx()) / training.fx();
  const double b0 = options.bounding_box ? surface.y() / z
                                         : (training.height() / 2.0 - 0.5 - training.cy()) / training.fy();
  const double width = (options.bounding_box ? config.box_width() : config.image_width()) / training.fx();
  const double height = (options.bounding_box ? config.box_height() : config.image_height()) / training.fy();
  for (std::uint32_t row = 0; row < config.rows(); ++row)
    for (std::uint32_t column = 0; column < config.columns(); ++column) {
      const double a = a0 + ((column + 0.5) / config.columns() - 0.5) * width * scale;
      const double b = b0 + ((row + 0.5) / config.rows() - 0.5) * height * scale;
      const Pixel at = image.pixel_of(a, b, z);
      const bool inside =
          at.u > -0.5 && at.v > -0.5 && at.u < image.width() - 0.5 && at.v < image.height() - 0.5;
      const std::optional<double> depth = inside ? image.filled(static_cast<int>(std::floor(at.u + 0.5)),
                                                                static_cast<int>(std::floor(at.v + 0.5)))
                                                 : std::nullopt;
      info.depth.push_back(training.normalise(depth ? *depth + (move ? home - z : 0) : training.far()));
    }

  // The click and the object's size as the training camera would measure them.
  const double ca = clicked.x() / clicked.z(), cb = clicked.y() / clicked.z();
  const double shift_a = move ? (ca - a0) / scale : ca, shift_b = move ? (cb - b0) / scale : cb;
  info.click_a = std::clamp((training.cx() + shift_a * training.fx() + 0.5) / training.width(), 0.0, 1.0);
  info.click_b = std::clamp((training.cy() + shift_b * training.fy() + 0.5) / training.height(), 0.0, 1.0);
  if (segment) {
    const Vec3 low = image.point({static_cast<double>(segment->left), static_cast<double>(segment->top)}, z);
    const Vec3 high = image.point({segment->right + 1.0, segment->bottom + 1.0}, z);
    info.box_w = std::min(1.0, (high.x() - low.x()) / (z * scale) * training.fx() / training.width());
    info.box_h = std::min(1.0, (high.y() - low.y()) / (z * scale) * training.fy() / training.height());
  }
  info.point = training.pose() * clicked;
  const Vec3 workspace_centre =
      grasp.has_workspace_centre() ? from_proto(grasp.workspace_centre()) : Vec3(0, 0, 0.125);
  info.anchor = options.bounding_box ? training.pose() * surface : workspace_centre;

  // Points where the training camera sees them: on the same rays, moved with the depths.
  const auto seen = [&](double a, double b, double depth) {
    const double at = move ? depth + home - z : depth;
    return Vec3(training.pose() * Vec3(a * at, b * at, at));
  };
  SampledView view;
  view.camera = &training;
  view.centre = {training.cx() + a0 * training.fx(), training.cy() + b0 * training.fy()};
  view.width = width * training.fx();
  view.height = height * training.fy();
  view.depth = info.depth;
  view.point = seen(a0 + shift_a - (move ? 0 : a0), b0 + shift_b - (move ? 0 : b0), clicked.z());
  view.anchor = options.bounding_box ? seen(a0, b0, z) : workspace_centre;
  view.unit = workspace_unit(grasp, options.bounding_box || config.object_frame());
  if (config.object_frame()) {
    view.anchor = object_anchor(config, view, options.bounding_box);
    const Vec3 moved = training.pose().inverse() * view.anchor;  // back on its ray, where it was recorded
    info.anchor = training.pose() * Vec3(moved * ((moved.z() - (move ? home - z : 0)) / moved.z()));
  }
  info.features = view_features(config, view);
  return info;
}

}  // namespace evograsp::sim

#include "sim/depth.h"

#include <algorithm>
#include <cmath>

#include "sim/kinect_noise.h"
#include "sim/view_features.h"

namespace evograsp::sim {
namespace {

// Draws before the visible pixels are counted: a target of which one pixel in a hundred shows is found by one
// of these with probability 0.92.
constexpr int kClickTries = 256;

// The integer pixels of a box that lie in the image.
struct PixelRange {
  int left, top, right, bottom;  // inclusive
  bool empty() const { return left > right || top > bottom; }
};
PixelRange pixels_of(const ImageBox& box, const Camera& camera) {
  const auto clip = [](double x, int size) {
    return static_cast<int>(std::clamp(x, -1.0, static_cast<double>(size)));
  };
  return {std::max(0, clip(std::ceil(box.left), camera.width())),
          std::max(0, clip(std::ceil(box.top), camera.height())),
          std::min(camera.width() - 1, clip(std::floor(box.right), camera.width())),
          std::min(camera.height() - 1, clip(std::floor(box.bottom), camera.height()))};
}

}  // namespace

Result<DepthCamera> DepthCamera::create(const proto::Experiment& experiment,
                                        const std::vector<proto::ObjectBundle>& objects) {
  DepthCamera out;
  out.config_ = experiment.camera();
  Result<Camera> camera = Camera::create(out.config_);
  if (!camera) return tl::unexpected(camera.error());
  out.camera_ = *camera;
  const proto::GraspConfig& grasp = experiment.grasp();
  out.box_unit_ = workspace_unit(grasp, true);
  out.workspace_unit_ = workspace_unit(grasp, false);
  out.workspace_centre_ =
      grasp.has_workspace_centre() ? from_proto(grasp.workspace_centre()) : Vec3(0, 0, 0.125);
  auto bodies = std::make_shared<std::vector<RayBody>>();
  for (const proto::ObjectBundle& object : objects) {
    Result<RayBody> body = RayBody::create(object);
    if (!body) return tl::unexpected(body.error());
    bodies->push_back(std::move(*body));
    out.centre_of_mass_.push_back(from_proto(object.centre_of_mass()));
    std::vector<Solid> parts;
    for (const proto::ConvexPart& part : object.part()) {
      Result<Solid> solid = Solid::create(part);
      if (!solid) return fail(solid.error().code, object.name() + ": " + solid.error().message);
      parts.push_back(std::move(*solid));
    }
    out.bounds_.emplace_back(std::move(parts));
  }
  out.caster_ = RayCaster(std::move(bodies), experiment.scene().table_half_size());
  return out;
}

Result<Pixel> DepthCamera::draw_click(const View& view, const ImageBox& box, std::uint64_t seed, int target,
                                      int click) const {
  const Camera& camera = view.camera;
  const PixelRange range = pixels_of(box, camera);
  const auto visible = [&](int u, int v) {
    const Hit hit =
        view.scene.cast(camera.ray({static_cast<double>(u), static_cast<double>(v)}), 0, camera.far());
    return hit.body == target && hit.t >= camera.near();
  };
  if (!range.empty()) {
    Random random(seed, Purpose::kClick, static_cast<std::uint64_t>(target),
                  static_cast<std::uint64_t>(click));
    for (int i = 0; i < kClickTries; ++i) {
      const int u = range.left +
                    static_cast<int>(random.below(static_cast<std::uint32_t>(range.right - range.left + 1)));
      const int v = range.top +
                    static_cast<int>(random.below(static_cast<std::uint32_t>(range.bottom - range.top + 1)));
      if (visible(u, v)) return Pixel{static_cast<double>(u), static_cast<double>(v)};
    }
    // Hardly visible: list what there is and draw from that.
    std::vector<Pixel> seen;
    for (int v = range.top; v <= range.bottom; ++v)
      for (int u = range.left; u <= range.right; ++u)
        if (visible(u, v)) seen.push_back({static_cast<double>(u), static_cast<double>(v)});
    if (!seen.empty()) return seen[random.below(static_cast<std::uint32_t>(seen.size()))];
  }
  return fail(ErrorCode::kInvalid,
              "camera: no pixel of target " + std::to_string(target) +
                  " is visible: it is hidden by other objects or out of the camera's range");
}

Ray DepthCamera::cell_ray(const View& view, bool bounding_box, int column, int row) const {
  const double columns = config_.columns(), rows = config_.rows();
  const Camera& camera = view.camera;
  if (!bounding_box)
    return camera.ray(
        {(column + 0.5) * camera.width() / columns - 0.5, (row + 0.5) * camera.height() / rows - 0.5});
  return camera.ray({view.centre.u + ((column + 0.5) / columns - 0.5) * config_.box_width(),
                     view.centre.v + ((row + 0.5) / rows - 0.5) * config_.box_height()});
}

void DepthCamera::sample(const View& view, bool bounding_box, Random* noise,
                         std::vector<float>* depth) const {
  const int columns = static_cast<int>(config_.columns()), rows = static_cast<int>(config_.rows());
  const Camera& camera = view.camera;
  depth->resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  std::size_t i = 0;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const Ray ray = cell_ray(view, bounding_box, column, row);
      const Hit hit = view.scene.cast(ray, 0, camera.far());
      double z = hit.t;
      if (noise) {
        z = hit.body == kNothing
                ? noisy_nothing(*noise, camera.far())
                : noisy_depth(config_.noise(), camera, ray, view.scene.normal(ray, hit), z, *noise);
      }
      (*depth)[i++] = camera.normalise(z);
    }
}

PosedScene DepthCamera::posed(const Placements& placements) const {
  return PosedScene(caster_, placements.pose, placements.present, placements.scale);
}

Vec3 DepthCamera::centre_of(const Placements& placements, std::size_t object) const {
  return placements.pose[object] * Vec3(placements.scale_of(object) * centre_of_mass_[object]);
}

void DepthCamera::measure_view(const Pixel& centre, bool bounding_box, Info* info) const {
  SampledView view;
  view.camera = &camera_;
  view.centre = bounding_box ? centre : Pixel{camera_.width() / 2.0 - 0.5, camera_.height() / 2.0 - 0.5};
  view.width = bounding_box ? config_.box_width() : camera_.width();
  view.height = bounding_box ? config_.box_height() : camera_.height();
  view.depth = info->depth;
  view.point = info->point;
  view.anchor = info->anchor;
  view.unit = bounding_box || config_.object_frame() ? box_unit_ : workspace_unit_;
  if (config_.object_frame()) view.anchor = info->anchor = object_anchor(config_, view, bounding_box);
  info->features = view_features(config_, view);
}

void DepthCamera::render(const Placements& placements, int target, bool bounding_box,
                         std::vector<float>* depth) const {
  const Camera camera = camera_.of_placement(placements.seed);
  const Vec3 centre = centre_of(placements, static_cast<std::size_t>(target));
  sample({camera, posed(placements), camera.project(centre).value_or(Pixel())}, bounding_box, nullptr, depth);
}

Result<Info> DepthCamera::look(const Placements& placements, int target, int click, bool bounding_box) const {
  const std::size_t index = static_cast<std::size_t>(target);
  if (target < 0 || index >= bounds_.size())
    return fail(ErrorCode::kInvalid,
                "camera: there is no object " + std::to_string(target) + " in this experiment");
  if (placements.pose.size() != bounds_.size() || placements.present.size() != bounds_.size())
    return fail(ErrorCode::kInvalid, "camera: the placements belong to another experiment");
  if (!placements.present[index])
    return fail(ErrorCode::kInvalid, "camera: object " + std::to_string(target) + " is not in this scene");
  const Camera camera = camera_.of_placement(placements.seed);
  const std::optional<Pixel> centre = camera.project(centre_of(placements, index));
  const std::optional<ImageBox> box =
      bounds_[index].project(camera, placements.pose[index], placements.scale_of(index));
  if (!centre || !box)
    return fail(ErrorCode::kInvalid,
                "camera: target " + std::to_string(target) + " reaches behind the camera");

  const View view{camera, posed(placements), *centre};
  Info info;
  const Result<Pixel> pixel = draw_click(view, *box, placements.seed, target, click);
  if (!pixel) return tl::unexpected(pixel.error());
  info.click_a = (pixel->u + 0.5) / camera.width();
  info.click_b = (pixel->v + 0.5) / camera.height();
  info.box_w = std::min(1.0, box->width() / camera.width());
  info.box_h = std::min(1.0, box->height() / camera.height());
  const auto surface = [&](const Pixel& at) {
    const Ray ray = camera.ray(at);
    return ray.at(view.scene.cast(ray, 0, camera.far()).t);
  };
  info.point = surface(*pixel);
  info.anchor = bounding_box ? surface(*centre) : workspace_centre_;
  Random noise(placements.seed, Purpose::kSensorNoise, static_cast<std::uint64_t>(target),
               static_cast<std::uint64_t>(click));
  sample(view, bounding_box, config_.has_noise() ? &noise : nullptr, &info.depth);
  measure_view(*centre, bounding_box, &info);
  return info;
}

void Info::write_inputs(std::span<float> inputs) const {
  std::copy(depth.begin(), depth.end(), inputs.begin());
  const std::size_t n = depth.size();
  inputs[n] = static_cast<float>(click_a);
  inputs[n + 1] = static_cast<float>(click_b);
  inputs[n + 2] = static_cast<float>(box_w);
  inputs[n + 3] = static_cast<float>(box_h);
  std::copy(features.begin(), features.end(), inputs.begin() + static_cast<std::ptrdiff_t>(n + 4));
}

}  // namespace evograsp::sim

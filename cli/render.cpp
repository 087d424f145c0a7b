// `evograsp render`: a picture of a scene, a grasp, or of what the network sees.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "cli/cli.h"
#include "cli/inputs.h"
#include "cli/json_values.h"
#include "cli/report.h"
#include "cli/scene_flags.h"
#include "sim/depth.h"
#include "sim/render_overlay.h"
#include "sim/render_scene.h"

namespace evograsp::cli {
namespace {

// Of --depth: tenths of a millimetre.
constexpr double kDepthUnitsPerMetre = 10000;

struct Options {
  SceneFlags scene;
  std::string out;
  std::string view = "corner";
  std::string size = "1280x960";
  std::string caption;
  int samples = 9;
  bool depth = false;
  bool input = false;
  bool no_contacts = false;
  bool json = false;
};

Status parse_size(const std::string& text, int* width, int* height) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", width, height, &rest) != 2 || *width < 16 || *height < 16 ||
      *width > 8192 || *height > 8192)
    return fail(ErrorCode::kUsage, "--size " + text + ": WIDTHxHEIGHT is wanted, 16 to 8192 each");
  return {};
}

struct Picture {
  const Options& options;
  const Trial& trial;
  const assets::ResolvedExperiment& what;
  sim::Camera depth_camera;
  int width = 0, height = 0;
  std::optional<sim::GraspReport> grasp;
};

Result<sim::RenderScene> scene_of(const Picture& picture) {
  sim::RenderScene scene;
  scene.table_half = picture.what.experiment.scene().table_half_size();
  if (Status s = sim::add_objects(scene, picture.what.objects, picture.trial.placements); !s)
    return tl::unexpected(s.error());
  if (!picture.grasp) return scene;
  const sim::GraspReport& grasp = *picture.grasp;
  if (!is_finite(grasp.palm)) return scene;
  if (Status s = sim::add_hand(scene, picture.what.hand, grasp.palm, grasp.joints); !s)
    return tl::unexpected(s.error());
  if (picture.options.no_contacts) return scene;
  if (Status s = sim::add_contacts(scene, grasp.contacts); !s) return tl::unexpected(s.error());
  return scene;
}

Result<sim::ColourImage> draw_view(const Picture& picture, const std::string& view, int width, int height) {
  const auto scene = scene_of(picture);
  if (!scene) return tl::unexpected(scene.error());
  // A grasp is about the target and the hand around it, a scene about all objects.
  sim::Subject subject = sim::subject_of(picture.what.objects, picture.trial.placements);
  if (picture.grasp && is_finite(picture.grasp->palm)) {
    const Vec3 target =
        picture.trial.placements.pose[static_cast<std::size_t>(picture.trial.target)].position;
    const double away = (picture.grasp->palm.position - target).norm();
    subject = {0.6 * target + 0.4 * picture.grasp->palm.position, std::clamp(0.10 + 0.5 * away, 0.13, 0.5)};
  }
  const auto camera = sim::choose_view(view, picture.depth_camera, subject, width, height);
  if (!camera) return tl::unexpected(camera.error());
  sim::RenderOptions how;
  how.light_samples = picture.options.samples;
  return sim::render(*scene, *camera, how);
}

// The camera's view with the window and the click; beside it the samples that the network gets.
Result<std::string> draw_input(const Picture& picture) {
  if (!picture.trial.info)
    return fail(ErrorCode::kInvalid, "the camera does not see the target: there is no input to show");
  const sim::Info& info = *picture.trial.info;
  const proto::CameraConfig& config = picture.what.experiment.camera();
  const double scale = static_cast<double>(picture.height) / picture.depth_camera.height();
  const int width = static_cast<int>(scale * picture.depth_camera.width());
  auto view = draw_view(picture, "camera", width, picture.height);
  if (!view) return tl::unexpected(view.error());
  const auto to_view = [&](double u, double v) {
    return sim::Pixel{(u + 0.5) * scale - 0.5, (v + 0.5) * scale - 0.5};
  };
  sim::Overlay overlay(*view);
  if (picture.trial.bounding_box) {
    const std::size_t target = static_cast<std::size_t>(picture.trial.target);
    const Vec3 centre = picture.trial.placements.pose[target] *
                        Vec3(picture.trial.placements.scale_of(target) *
                             from_proto(picture.what.objects[target].centre_of_mass()));
    if (const auto at = picture.depth_camera.project(centre)) {
      const sim::Pixel low = to_view(at->u - config.box_width() / 2.0, at->v - config.box_height() / 2.0);
      const sim::Pixel high = to_view(at->u + config.box_width() / 2.0, at->v + config.box_height() / 2.0);
      overlay.rectangle({low.u, low.v, high.u, high.v});
    }
  }
  overlay.cross(
      to_view(info.click_a * config.image_width() - 0.5, info.click_b * config.image_height() - 0.5));
  const int columns = static_cast<int>(config.columns()), rows = static_cast<int>(config.rows());
  const int cell = std::max(1, picture.height / rows);
  return sim::encode_png(sim::beside(overlay.finish(), sim::colour_depth(info.depth, columns, rows, cell),
                                     std::max(8, picture.height / 40)));
}

Result<std::string> draw_depth(const Picture& picture) {
  sim::Camera camera = picture.depth_camera;
  auto bodies = std::make_shared<std::vector<sim::RayBody>>();
  for (const proto::ObjectBundle& object : picture.what.objects) {
    auto body = sim::RayBody::create(object);
    if (!body) return tl::unexpected(body.error());
    bodies->push_back(std::move(*body));
  }
  const sim::RayCaster caster(std::move(bodies), picture.what.experiment.scene().table_half_size());
  const sim::PosedScene scene(caster, picture.trial.placements.pose, picture.trial.placements.present,
                              picture.trial.placements.scale);
  return sim::encode_png(sim::render_depth(scene, camera, kDepthUnitsPerMetre));
}

Result<std::string> draw_scene(const Picture& picture) {
  auto image = draw_view(picture, picture.options.view, picture.width, picture.height);
  if (!image) return tl::unexpected(image.error());
  if (picture.options.caption.empty()) return sim::encode_png(*image);
  sim::Overlay overlay(*image);
  overlay.caption(picture.options.caption);
  return sim::encode_png(overlay.finish());
}

Status draw(const Options& options) {
  if (options.depth && options.input)
    return fail(ErrorCode::kUsage, "--depth and --input exclude each other");
  auto trial = prepare_trial(options.scene);
  if (!trial) return tl::unexpected(trial.error());
  const assets::ResolvedExperiment& what = trial->session->experiment();
  auto camera = sim::Camera::create(what.experiment.camera());
  if (!camera) return tl::unexpected(camera.error());
  Picture picture{options, *trial, what, camera->of_placement(trial->placements.seed), 0, 0, std::nullopt};
  if (Status s = parse_size(options.size, &picture.width, &picture.height); !s) return s;
  if (trial->tool && !options.depth && !options.input) {
    auto grasp = trial->session->get_quality(trial->target, *trial->tool);
    if (!grasp) return tl::unexpected(grasp.error());
    picture.grasp = std::move(*grasp);
  }
  const auto bytes = options.depth   ? draw_depth(picture)
                     : options.input ? draw_input(picture)
                                     : draw_scene(picture);
  if (!bytes) return tl::unexpected(bytes.error());
  if (Status s = write_file(options.out, *bytes); !s) return s;
  if (!options.json) return {};
  nlohmann::ordered_json json;
  json["out"] = options.out;
  json["bytes"] = bytes->size();
  if (options.depth) json["units_per_metre"] = kDepthUnitsPerMetre;
  if (picture.grasp) json["measurement"] = to_json(picture.grasp->measurement);
  std::printf("%s\n", json.dump(1).c_str());
  return {};
}

}  // namespace

void add_render(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub =
      app.add_subcommand("render", "draw a scene, a grasp with its contacts, or what the network sees");
  sub->add_option("--out", options->out, "the PNG file to write")->required()->type_name("FILE");
  sub->add_option("--view", options->view,
                  "corner, front, side, top, camera (the depth camera's) or an eye \"x y z\" (m)")
      ->capture_default_str();
  sub->add_option("--size", options->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  sub->add_flag("--depth", options->depth,
                "the depth camera's whole image, 16 bits, tenths of a millimetre, 0 no return");
  sub->add_flag("--input", options->input, "the camera's view beside the depth samples of the network");
  sub->add_flag("--no-contacts", options->no_contacts, "leave out contacts and friction cones");
  sub->add_option("--caption", options->caption, "words in the lower left corner");
  sub->add_option("--samples", options->samples, "shadow rays a ray: more is smoother and slower")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  add_scene_flags(*sub, options->scene);
  sub->add_flag("--json", options->json, "say what was drawn, machine-readable");
  sub->footer(
      "Examples:\n"
      "  evograsp render --champion runs/quick --seed 3 --out grasp.png\n"
      "  evograsp render --object mug --view top --size 640x480 --out mug.png\n"
      "  evograsp render --object cube --depth --out depth.png    (then: evograsp infer ... --depth "
      "depth.png)");
  sub->callback([options, &outcome] {
    const Status status = draw(*options);
    outcome.exit_code = status ? kExitOk : report(status.error());
  });
}

}  // namespace evograsp::cli

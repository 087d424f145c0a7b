// `evograsp infer`: what a champion answers to a recorded depth image.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "assets/assets.h"
#include "cli/camera_file.h"
#include "cli/champion_assets.h"
#include "cli/cli.h"
#include "cli/inputs.h"
#include "cli/json_values.h"
#include "cli/report.h"
#include "cli/scene_flags.h"
#include "common/network.h"
#include "sim/decode.h"
#include "sim/depth_image.h"
#include "sim/view_features.h"

namespace evograsp::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string champion;
  std::string depth;
  std::string camera;
  std::string click;
  std::string hand;
  BoxFlags box;
  bool keep_distance = false;
  bool centre_on_click = false;
  std::string camera_pose;
  std::string robot_pose;
  bool json = false;
};

struct Answer {
  sim::Info info;
  Pose tool_camera;   // X_CT
  Pose tool_to_palm;  // X_TH
  bool bounding_box = true;
};

Status parse_click(const std::string& text, int* u, int* v) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d,%d%c", u, v, &rest) != 2)
    return fail(ErrorCode::kUsage, "--click " + text + ": U,V is wanted, the clicked pixel's column and row");
  return {};
}

// A pose that no robot shall be sent to is refused; one that training never met is told.
Status check_pose(const Answer& answer, const proto::Config& config, const Options& options) {
  constexpr double kNowhere = 1000;  // m
  const Vec3 &tool = answer.tool_camera.position, &click = answer.info.point;
  if (!is_finite(answer.tool_camera) || !(tool.cwiseAbs().maxCoeff() < kNowhere))
    return fail(ErrorCode::kInvalid, options.champion + ": the network's answer is no place a hand could go");
  if (!(tool.z() > 0))
    return fail(ErrorCode::kInvalid,
                options.depth + ": the answer lies behind the camera; are the depths in other units?");
  const double low = config.camera().near(), high = config.camera().far();
  char text[160];
  std::snprintf(text, sizeof text,
                "the clicked surface is %.3g m away; in training the camera saw %.3g to %.3g m", click.z(),
                low, high);
  if (click.z() < low || click.z() > high) warn(options.depth + ": " + text);
  const double reach = config.grasp().wrist_reach();
  if ((tool - click).norm() > reach)
    warn(options.champion + ": the answer is farther from the click than a wrist reached in training");
  return {};
}

Result<proto::HandBundle> hand_of(const Options& options, const proto::Champion& champion) {
  if (!options.hand.empty()) return load_hand(options.hand);
  auto trained = trained_bundles(options.champion, champion, {true, false, "--hand"});
  if (!trained) return tl::unexpected(trained.error());
  if (trained->hand) return std::move(*trained->hand);
  return load_hand(champion.experiment().grasp().hand());
}

Result<Answer> ask(const Options& options) {
  const auto champion = read_champion(options.champion);
  if (!champion) return tl::unexpected(champion.error());
  const proto::Config& config = champion->experiment();
  const auto hand = hand_of(options, *champion);
  if (!hand) return tl::unexpected(hand.error());
  const auto training = sim::Camera::create(config.camera());
  if (!training) return tl::unexpected(training.error());

  const auto grey = sim::read_grey16(options.depth);
  if (!grey) return tl::unexpected(grey.error());
  const auto camera = read_camera(options.camera, *grey);
  if (!camera) return tl::unexpected(camera.error());
  const auto image = sim::DepthImage::create(*grey, *camera);
  if (!image) return fail(image.error().code, options.depth + ": " + image.error().message);
  int u = 0, v = 0;
  if (Status s = parse_click(options.click, &u, &v); !s) return tl::unexpected(s.error());

  Answer answer;
  answer.bounding_box = options.box.choose(config.trials().bounding_box());
  const sim::RecordedOptions how{answer.bounding_box, !options.keep_distance, !options.centre_on_click};
  auto info = sim::look_at_recording(*image, config.camera(), *training, config.grasp(), u, v, how);
  if (!info) return fail(info.error().code, options.depth + ": " + info.error().message);
  answer.info = std::move(*info);

  const auto network = Network::from_proto(champion->network());
  if (!network) return tl::unexpected(network.error());
  const std::size_t inputs = answer.info.input_count();
  if (network->inputs() != static_cast<int>(inputs) || network->outputs() != sim::kOutputs)
    return fail(ErrorCode::kInvalid, options.champion + ": the network does not fit its own camera");
  std::vector<float> in(inputs), out(sim::kOutputs);
  answer.info.write_inputs(in);
  Network::Scratch scratch;
  network->activate(in, out, scratch);
  const Pose tool = sim::decode_pose(config.grasp(), sim::home_rotation(config.grasp(), *hand), out,
                                     answer.info, answer.bounding_box || config.camera().object_frame(),
                                     sim::pose_frame(config.camera(), answer.info.features));
  answer.tool_camera = training->pose().inverse() * tool;
  answer.tool_to_palm.position = -from_proto(hand->tool_point());
  // Positions of the answer leave the training world for the camera that recorded.
  answer.info.point = training->pose().inverse() * answer.info.point;
  answer.info.anchor = training->pose().inverse() * answer.info.anchor;
  if (Status s = check_pose(answer, config, options); !s) return tl::unexpected(s.error());
  return answer;
}

Json frame_json(const Pose& X_FC, const Answer& answer) {
  Json out;
  const Pose tool = X_FC * answer.tool_camera;
  out["tool"] = to_json(tool);
  out["palm"] = to_json(tool * answer.tool_to_palm);
  out["clicked_point"] = to_json(X_FC * answer.info.point);
  return out;
}

void print_frame(const char* name, const Pose& X_FC, const Answer& answer) {
  const Pose tool = X_FC * answer.tool_camera, palm = tool * answer.tool_to_palm;
  const proto::Quat q = evograsp::to_proto(tool.rotation);
  std::printf("%s frame\n", name);
  std::printf("  tool point   %9.4f %9.4f %9.4f m\n", tool.position.x(), tool.position.y(),
              tool.position.z());
  std::printf("  palm         %9.4f %9.4f %9.4f m\n", palm.position.x(), palm.position.y(),
              palm.position.z());
  std::printf("  orientation  %9.4f %9.4f %9.4f %9.4f (w x y z)\n", q.w(), q.x(), q.y(), q.z());
}

Status infer(const Options& options) {
  std::optional<Pose> X_WC, X_WR;
  for (const auto& [text, flag, pose] : {std::tuple{&options.camera_pose, "--camera-pose", &X_WC},
                                         {&options.robot_pose, "--robot-pose", &X_WR}}) {
    if (text->empty()) continue;
    auto parsed = parse_quaternion_pose(*text, flag);
    if (!parsed) return tl::unexpected(parsed.error());
    *pose = *parsed;
  }
  if (X_WR && !X_WC)
    return fail(ErrorCode::kUsage, "--robot-pose needs --camera-pose: both are poses in the world");
  const auto answer = ask(options);
  if (!answer) return tl::unexpected(answer.error());
  const double away = (answer->tool_camera.position - answer->info.point).norm();
  if (!options.json) {
    std::printf("tool point %.1f mm from the clicked surface point\n", 1000 * away);
    print_frame("camera", Pose(), *answer);
    if (X_WC) print_frame("world", *X_WC, *answer);
    if (X_WR) print_frame("robot", X_WR->inverse() * *X_WC, *answer);
    return {};
  }
  Json out;
  out["bounding_box"] = answer->bounding_box;
  out["distance_from_click"] = away;
  out["camera"] = frame_json(Pose(), *answer);
  if (X_WC) out["world"] = frame_json(*X_WC, *answer);
  if (X_WR) out["robot"] = frame_json(X_WR->inverse() * *X_WC, *answer);
  std::printf("%s\n", out.dump(1).c_str());
  return {};
}

}  // namespace

void add_infer(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("infer", "ask a champion for a hand pose on a recorded depth image");
  sub->add_option("champion", options->champion, "champion.pb or its run folder")->required();
  sub->add_option("--depth", options->depth, "16-bit depth image, PNG or PGM")->required()->type_name("FILE");
  sub->add_option("--camera", options->camera,
                  "JSON with fx, fy, cx, cy, units_per_metre, invalid (default: a registered Kinect frame in "
                  "millimetres)")
      ->type_name("FILE");
  sub->add_option("--click", options->click, "the clicked pixel: column, row")->required()->type_name("U,V");
  sub->add_option("--hand", options->hand, "name or hand file [the one it was trained with]");
  add_box_flags(*sub, options->box);
  sub->add_flag("--keep-distance", options->keep_distance,
                "take depths as they are, instead of as if the object stood at the training distance");
  sub->add_flag("--centre-on-click", options->centre_on_click,
                "centre the window on the click, instead of on the object under it");
  sub->add_option("--camera-pose", options->camera_pose,
                  "camera in the world (x right, y down, z forward): position and quaternion")
      ->type_name("\"X Y Z QW QX QY QZ\"");
  sub->add_option("--robot-pose", options->robot_pose, "robot base in the world: position and quaternion")
      ->type_name("\"X Y Z QW QX QY QZ\"");
  sub->add_flag("--json", options->json, "machine-readable");
  sub->footer(
      "The tool frame has its origin between the fingertips and the axes of the palm. The network acts as "
      "seen from its\n"
      "training camera: the pose is right with respect to gravity when the recording camera is tilted like "
      "that one.\n\n"
      "Example:\n"
      "  evograsp infer runs/cube --depth frame.png --camera camera.json --click 312,240 --json");
  sub->callback([options, &outcome] {
    const Status status = infer(*options);
    outcome.exit_code = status ? kExitOk : report(status.error());
  });
}

}  // namespace evograsp::cli

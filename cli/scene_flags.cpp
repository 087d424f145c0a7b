#include "cli/scene_flags.h"

#include <sstream>

#include "cli/champion_assets.h"
#include "cli/inputs.h"
#include "cli/report.h"
#include "common/network.h"
#include "common/zap.h"
#include "sim/decode.h"
#include "sim/view_features.h"

namespace evograsp::cli {
namespace {

// Exactly `count` finite numbers, apart by white space or commas.
std::optional<std::vector<double>> numbers(std::string text, std::size_t count) {
  for (char& c : text)
    if (c == ',') c = ' ';
  std::istringstream in(text);
  std::vector<double> out;
  std::string word;
  while (in >> word) {
    char* end = nullptr;
    out.push_back(std::strtod(word.c_str(), &end));
    if (end == word.c_str() || *end != '\0' || out.size() > count) return std::nullopt;
  }
  if (out.size() != count) return std::nullopt;
  return out;
}

proto::Config default_config() {
  proto::Config config;
  config.mutable_scene(), config.mutable_camera(), config.mutable_grasp();
  config.mutable_trials(), config.mutable_fitness();
  write_defaults(config);
  return config;
}

Error joined(const std::vector<Diagnostic>& diagnostics) {
  return {ErrorCode::kInvalid, text(diagnostics)};
}

struct Source {
  proto::Config config;
  std::filesystem::path base;
  std::optional<proto::Champion> champion;
};

// The config that the flags name, before --object and --hand.
Result<Source> source_of(const SceneFlags& flags) {
  if (!flags.config.empty() && !flags.champion.empty())
    return fail(ErrorCode::kUsage,
                "--config and --champion exclude each other: a champion brings its own config");
  if (!flags.pose.empty() && !flags.champion.empty())
    return fail(ErrorCode::kUsage, "--pose and --champion exclude each other");
  Source source;
  if (!flags.champion.empty()) {
    Result<proto::Champion> champion = read_champion(flags.champion);
    if (!champion) return tl::unexpected(champion.error());
    source.config = champion->experiment();
    source.champion = std::move(*champion);
    return source;
  }
  if (flags.config.empty()) {
    if (!flags.overrides.empty())
      return fail(ErrorCode::kUsage, "--set changes a config: name one with --config");
    source.config = default_config();
    return source;
  }
  auto loaded = load_config(flags.config, flags.overrides, known_names());
  if (!loaded) return tl::unexpected(joined(loaded.error()));
  source.config = loaded->config;
  source.base = loaded->base;
  return source;
}

Status apply(const SceneFlags& flags, Source& source) {
  proto::SceneConfig& scene = *source.config.mutable_scene();
  if (!flags.objects.empty()) {
    scene.clear_object();
    for (const std::string& object : flags.objects) {
      // Files that flags name are relative to the working folder, not to the config's.
      std::error_code error;
      const bool file =
          std::filesystem::exists(object, error) && !std::filesystem::is_directory(object, error);
      scene.add_object(file ? std::filesystem::absolute(object).string() : object);
    }
  }
  if (scene.object_size() == 0) {
    if (!flags.config.empty() || !flags.champion.empty() || !flags.objects.empty())
      return fail(ErrorCode::kUsage, "there is no object on the table: name one with --object");
    scene.add_object("cube");
  }
  if (!flags.hand.empty()) source.config.mutable_grasp()->set_hand(flags.hand);
  if (flags.scale > 0) scene.set_mesh_scale(flags.scale);
  if (flags.mass > 0) scene.set_mesh_mass(flags.mass);
  return {};
}

// A champion's own objects and hand come from its run, unless flags name others.
Result<assets::ResolvedExperiment> resolve(const SceneFlags& flags, const Source& source) {
  if (!source.champion) return assets::resolve_experiment(source.config, source.base);
  const NamedAssets named{!flags.objects.empty() || flags.scale > 0 || flags.mass > 0, !flags.hand.empty(),
                          "--object (a hand by --hand)"};
  auto trained = trained_bundles(flags.champion, *source.champion, named);
  if (!trained) return tl::unexpected(trained.error());
  if (named.objects) trained->objects.clear();
  if (named.hand) trained->hand.reset();
  return resolve_trained(source.config, *trained, named.flags);
}

// What simulates: here, or on a master's worker, which has an experiment of its own.
Result<std::unique_ptr<SimSession>> session_of(const SceneFlags& flags, Source& source) {
  if (flags.connect.empty()) {
    if (Status status = apply(flags, source); !status) return tl::unexpected(status.error());
    auto resolved = resolve(flags, source);
    if (!resolved) return tl::unexpected(resolved.error());
    for (const std::string& warning : resolved->warnings) warn(warning);
    return local_session(std::move(*resolved));
  }
  if (!flags.objects.empty() || !flags.hand.empty() || flags.scale > 0 || flags.mass > 0)
    return fail(ErrorCode::kUsage,
                "--connect: the master's experiment says which objects and hand there are: no "
                "--object, --hand, --scale or --mass");
  std::optional<CurveKeys> keys;
  if (!flags.key_file.empty()) {
    auto loaded = load_keys(flags.key_file);
    if (!loaded) return tl::unexpected(loaded.error());
    keys = std::move(*loaded);
  }
  auto session = remote_session(flags.connect, keys);
  if (!session) return session;
  const proto::Experiment& there = (*session)->experiment().experiment;
  if (source.champion && source.champion->fingerprint() != there.fingerprint())
    warn(flags.champion + ": was not trained with the experiment of " + flags.connect +
         "; hand, camera or objects differ");
  *source.config.mutable_trials() = there.trials();
  return session;
}

Result<int> choose_target(int wanted, const sim::Placements& placements) {
  const int count = static_cast<int>(placements.present.size());
  if (wanted >= count)
    return fail(ErrorCode::kUsage, "--target " + std::to_string(wanted) + ": there are " +
                                       std::to_string(count) + " objects, counted from 0");
  if (wanted >= 0 && !placements.present[static_cast<std::size_t>(wanted)])
    return fail(ErrorCode::kUsage,
                "--target " + std::to_string(wanted) + " is not in the scene of this seed");
  if (wanted >= 0) return wanted;
  for (int i = 0; i < count; ++i)
    if (placements.present[static_cast<std::size_t>(i)]) return i;
  return fail(ErrorCode::kInvalid, "the scene of this seed is empty");
}

Result<Pose> ask_network(const proto::Champion& champion, const sim::Info& info,
                         const assets::ResolvedExperiment& what, bool bounding_box) {
  Result<Network> network = Network::from_proto(champion.network());
  if (!network) return tl::unexpected(network.error());
  const std::size_t inputs = info.input_count();
  if (network->inputs() != static_cast<int>(inputs) || network->outputs() != sim::kOutputs)
    return fail(ErrorCode::kInvalid, "the champion has " + std::to_string(network->inputs()) +
                                         " inputs and " + std::to_string(network->outputs()) +
                                         " outputs; this camera gives " + std::to_string(inputs) +
                                         " and a pose needs " + std::to_string(sim::kOutputs));
  std::vector<float> in(inputs), out(sim::kOutputs);
  info.write_inputs(in);
  Network::Scratch scratch;
  network->activate(in, out, scratch);
  const proto::GraspConfig& grasp = what.experiment.grasp();
  return sim::decode_pose(grasp, sim::home_rotation(grasp, what.hand), out, info,
                          bounding_box || what.experiment.camera().object_frame(),
                          sim::pose_frame(what.experiment.camera(), info.features));
}

}  // namespace

void add_box_flags(CLI::App& sub, BoxFlags& flags) {
  CLI::Option* on = sub.add_flag("--box", flags.on, "see the target's window (default: as configured)");
  sub.add_flag("--no-box", flags.off, "see the whole image")->excludes(on);
}

void add_scene_flags(CLI::App& sub, SceneFlags& flags) {
  sub.add_option("--seed", flags.seed, "of the placement: the same seed, the same scene")
      ->capture_default_str();
  sub.add_option("--object", flags.objects,
                 "what stands on the table: names, object files, mesh files (with commas)")
      ->delimiter(',')
      ->type_name("LIST")
      ->allow_extra_args(false);
  sub.add_option("--target", flags.target, "which object to grasp, counted from 0 (default: the first)")
      ->check(CLI::NonNegativeNumber)
      ->default_str("");
  sub.add_option("--pose", flags.pose,
                 "tool point (m, world), rotation axis and angle (rad) relative to the home orientation")
      ->type_name("\"X Y Z AX AY AZ R\"");
  sub.add_option("--champion", flags.champion,
                 "a network that chooses the pose: champion.pb or its run folder")
      ->type_name("FILE");
  sub.add_option("--click", flags.click, "which of the trial's clicks the network sees")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  add_box_flags(sub, flags.box);
  sub.add_option("--config", flags.config, "scene, camera and hand from this config")->type_name("FILE");
  sub.add_option("--set", flags.overrides, "change a value of the config, e.g. camera.columns=40")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  sub.add_option("--hand", flags.hand, "name or hand file");
  sub.add_option("--scale", flags.scale, "mesh file units to metres")
      ->check(CLI::PositiveNumber)
      ->default_str("");
  sub.add_option("--mass", flags.mass, "of mesh files, kg")->check(CLI::PositiveNumber)->default_str("");
}

Result<Pose> parse_axis_angle_pose(const std::string& text, const Mat3& home) {
  const auto n = numbers(text, 7);
  if (!n)
    return fail(ErrorCode::kUsage, "--pose \"" + text +
                                       "\": seven numbers are wanted, \"x y z ax ay az r\": the tool "
                                       "point in metres, a rotation axis, an angle in radians");
  const std::vector<double>& v = *n;
  return Pose{axis_angle(Vec3(v[3], v[4], v[5]), v[6]) * home, Vec3(v[0], v[1], v[2])};
}

Result<Pose> parse_quaternion_pose(const std::string& text, const std::string& flag) {
  const auto n = numbers(text, 7);
  if (!n || !is_finite(Vec3((*n)[0], (*n)[1], (*n)[2])))
    return fail(ErrorCode::kUsage,
                flag + " \"" + text + "\": seven numbers are wanted, \"x y z qw qx qy qz\"");
  const std::vector<double>& v = *n;
  const double size = v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6];
  if (!(size > 1e-12 && size < 1e12))
    return fail(ErrorCode::kUsage, flag + ": the quaternion has no direction");
  return Pose{rotation_from_quaternion(v[3], v[4], v[5], v[6]), Vec3(v[0], v[1], v[2])};
}

Result<Trial> prepare_trial(const SceneFlags& flags) {
  Result<Source> source = source_of(flags);
  if (!source) return tl::unexpected(source.error());
  auto session = session_of(flags, *source);
  if (!session) return tl::unexpected(session.error());

  Trial trial;
  trial.session = std::move(*session);
  trial.config = source->config;
  trial.bounding_box = flags.box.choose(source->config.trials().bounding_box());
  auto placements = trial.session->shuffle(flags.seed);
  if (!placements) return tl::unexpected(placements.error());
  trial.placements = std::move(*placements);
  auto target = choose_target(flags.target, trial.placements);
  if (!target) return tl::unexpected(target.error());
  trial.target = *target;

  auto info = trial.session->get_info(trial.target, flags.click, trial.bounding_box);
  if (info) {
    trial.info = std::move(*info);
  } else if (source->champion) {
    return tl::unexpected(info.error());
  } else {
    warn(info.error().message);
  }
  const assets::ResolvedExperiment& what = trial.session->experiment();
  if (!flags.pose.empty()) {
    auto pose = parse_axis_angle_pose(flags.pose, sim::home_rotation(what.experiment.grasp(), what.hand));
    if (!pose) return tl::unexpected(pose.error());
    trial.tool = *pose;
  } else if (source->champion) {
    auto pose = ask_network(*source->champion, *trial.info, what, trial.bounding_box);
    if (!pose) return tl::unexpected(pose.error());
    trial.tool = *pose;
  }
  return trial;
}

}  // namespace evograsp::cli

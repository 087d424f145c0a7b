#include "common/config_check.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/near_miss.h"

namespace evograsp {
namespace {

using Complain = std::function<void(const std::string&, const std::string&)>;

// Enough for any study; more would not fit a generation's list of trials into memory.
constexpr std::uint64_t kMostTrials = 1'000'000;

void check_scene(const proto::Config& config, const Complain& complain) {
  const proto::SceneConfig& scene = config.scene();
  const int objects = scene.object_size();
  if (objects == 0)
    complain("scene.object", "nothing to grasp: name at least one object, e.g. object: \"cylinder\"");
  if (static_cast<int>(scene.objects_in_scene()) > objects) {
    complain("scene.objects_in_scene", "is more than the " + std::to_string(objects) + " objects listed");
  }
  if (scene.placement_half_x() > scene.table_half_size()) {
    complain("scene.placement_half_x",
             "objects would stand beside the table: it is at most scene.table_half_size");
  }
  if (scene.placement_half_y() > scene.table_half_size()) {
    complain("scene.placement_half_y",
             "objects would stand beside the table: it is at most scene.table_half_size");
  }
  for (int i = 0; i < scene.friction_size(); ++i) {
    const proto::FrictionPair& pair = scene.friction(i);
    if (pair.a().empty() || pair.b().empty() || !pair.has_mu()) {
      complain("scene.friction[" + std::to_string(i) + "]", "a friction pair needs a, b (materials) and mu");
    }
  }
  const proto::TrialsConfig& trials = config.trials();
  const std::uint64_t targets =
      trials.every_object() && objects > 0
          ? static_cast<std::uint64_t>(scene.objects_in_scene() > 0
                                           ? std::min(static_cast<int>(scene.objects_in_scene()), objects)
                                           : objects)
          : 1;
  const std::uint64_t count = std::uint64_t{trials.scenes()} * trials.clicks() * targets;
  if (count > kMostTrials) {
    complain("trials.scenes", "scenes x clicks x objects are " + std::to_string(count) +
                                  " trials a genome, allowed are at most " + std::to_string(kMostTrials));
  }
}

// Each of the bests is validated on each trial, and what they measured is kept.
void check_champion(const proto::ChampionConfig& champion, const Complain& complain) {
  const std::uint64_t count = std::uint64_t{champion.candidates()} * champion.validation_trials();
  if (count > kMostTrials)
    complain("champion.validation_trials", "champion.candidates x validation_trials are " +
                                               std::to_string(count) + " trials, allowed are at most " +
                                               std::to_string(kMostTrials));
}

void check_camera(const proto::CameraConfig& camera, const Complain& complain) {
  if (!(camera.near() < camera.far())) complain("camera.far", "must lie beyond camera.near");
  if (camera.columns() > camera.image_width())
    complain("camera.columns", "more samples than the image has columns");
  if (camera.rows() > camera.image_height()) complain("camera.rows", "more samples than the image has rows");
  if (camera.box_width() > camera.image_width())
    complain("camera.box_width", "the window is wider than the image");
  if (camera.box_height() > camera.image_height())
    complain("camera.box_height", "the window is taller than the image");
  if (camera.object_frame() && std::ranges::find(camera.feature(), proto::AXIS) == camera.feature().end())
    complain("camera.object_frame", "needs AXIS among camera.feature, which measures how the object lies");
  if (camera.eye().x() == 0 && camera.eye().y() == 0 && camera.eye().z() == 0) {
    complain("camera.eye", "lies in the world origin, which the camera looks at");
  }
}

void check_fitness(const proto::FitnessConfig& fitness, const Complain& complain) {
  static const std::vector<std::string> kTerms = {"1", "12", "13", "14", "123", "124", "134", "1234"};
  bool known = false;
  for (const std::string& terms : kTerms) known = known || terms == fitness.terms();
  if (!known) complain("fitness.terms", "is \"" + fitness.terms() + "\", allowed are " + join_words(kTerms));
  if (fitness.theta_min() > fitness.theta_max())
    complain("fitness.theta_max", "lies below fitness.theta_min");
}

void check_neat(const proto::NeatConfig& neat, const Complain& complain) {
  if (neat.topology() == proto::HIDDEN_LAYER && neat.hidden() == 0 && !neat.has_hyperneat()) {
    complain("neat.hidden", "a hidden layer of no nodes connects nothing: use topology: DIRECT");
  }
  for (int i = 0; i < neat.hyperneat().hidden_sheet_size(); ++i) {
    const proto::SubstrateSheet& sheet = neat.hyperneat().hidden_sheet(i);
    if (sheet.has_columns() && sheet.has_rows()) continue;
    complain("neat.hyperneat.hidden_sheet[" + std::to_string(i) + "]", "a sheet needs columns and rows");
  }
}

void check_archive(const proto::NeatConfig& neat, const Complain& complain) {
  if (!neat.has_archive()) return;
  const proto::ArchiveConfig& archive = neat.archive();
  const auto check_axis = [&](const char* name, const proto::ArchiveAxis& axis) {
    const std::string key = std::string("neat.archive.") + name;
    if (axis.has_low() != axis.has_high())
      complain(key, "low and high are given together, or neither");
    else if (axis.has_low() && !(axis.low() < axis.high()))
      complain(key + ".high", "must lie above low");
  };
  check_axis("x", archive.x());
  check_axis("y", archive.y());
  if (archive.x().of() == archive.y().of())
    complain("neat.archive.y.of", "is the measure of x, too: two different ones span a map");
  if (archive.children() + archive.again() > 1)
    complain("neat.archive.children", "and again are shares of the population: at most 1 together");
  constexpr std::uint32_t kMostCompared = 20'000;
  if (archive.kind() == proto::NOVELTY && neat.population() > kMostCompared)
    complain("neat.population",
             "novelty compares all with all: with it at most " + std::to_string(kMostCompared) + " genomes");
}

// What a substrate must share with the camera and the hand.
void check_hyperneat(const proto::Config& config, const Complain& complain) {
  if (!config.neat().has_hyperneat()) return;
  const proto::HyperNeatConfig& substrate = config.neat().hyperneat();
  const auto same = [&](const char* end, std::uint32_t given, std::uint32_t camera) {
    if (given == camera) return;
    complain("neat.hyperneat.input_" + std::string(end), "is " + std::to_string(given) + ", but camera." +
                                                             end + " is " + std::to_string(camera) +
                                                             ": leave it out, then it follows the camera");
  };
  same("columns", substrate.input_columns(), config.camera().columns());
  same("rows", substrate.input_rows(), config.camera().rows());
  constexpr std::uint32_t kPose = 7;  // position, axis, angle
  if (substrate.outputs() != kPose)
    complain("neat.hyperneat.outputs",
             "is " + std::to_string(substrate.outputs()) + ", but a pose of the hand is 7 numbers");
  if (config.neat().recurrent())
    complain("neat.recurrent", "substrates are feed-forward: with hyperneat it must be false");
}

// It becomes the name of the run's folder.
void check_name(const std::string& name, const Complain& complain) {
  const bool printable = std::none_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f || c == '/';
  });
  if (name.empty() || name == "." || name == ".." || name.size() > kLongestRunName || !printable)
    complain("run.name", "is no name for a folder: no '/', no control characters, at most 100 bytes");
}

void check_net(const proto::NetConfig& net, const Complain& complain) {
  if (!(net.heartbeat_seconds() < net.silence_seconds())) {
    complain("net.silence_seconds",
             "must be longer than net.heartbeat_seconds, or every peer counts as lost");
  }
  const auto is_endpoint = [](std::string_view s) {
    return s.starts_with("tcp://") || s.starts_with("ipc://") || s.starts_with("inproc://");
  };
  const char* kShape = "is not an address: tcp://HOST:PORT (tcp://*:PORT for every interface) or ipc://FILE";
  if (!is_endpoint(net.listen())) complain("net.listen", kShape);
  if (!net.publish().empty() && !is_endpoint(net.publish())) complain("net.publish", kShape);
  if (!net.http().empty() && net.http().find(':') == std::string::npos) {
    complain("net.http", "is not HOST:PORT (empty switches it off)");
  }
}

}  // namespace

void check_config(const proto::Config& config, const Complain& complain) {
  if (config.run().has_name()) check_name(config.run().name(), complain);
  check_scene(config, complain);
  check_champion(config.champion(), complain);
  check_camera(config.camera(), complain);
  check_fitness(config.fitness(), complain);
  check_neat(config.neat(), complain);
  check_archive(config.neat(), complain);
  check_hyperneat(config, complain);
  check_net(config.net(), complain);
}

}  // namespace evograsp

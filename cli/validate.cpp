// `evograsp validate FILE...`: can it be used, and if not, why not?
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "assets/assets.h"
#include "assets/experiment.h"
#include "cli/cli.h"
#include "cli/inputs.h"
#include "cli/progress.h"
#include "cli/report.h"
#include "common/config.h"
#include "proto/hand.pb.h"
#include "proto/object.pb.h"
#include "score/score.h"
#include "sim/simulator.h"

namespace evograsp::cli {
namespace {

namespace fs = std::filesystem;

enum class Kind { kConfig, kObject, kHand, kMesh };

const char* kind_name(Kind kind) {
  switch (kind) {
    case Kind::kObject:
      return "object";
    case Kind::kHand:
      return "hand";
    case Kind::kMesh:
      return "mesh";
    case Kind::kConfig:
      break;
  }
  return "config";
}

// What is said about one file.
struct Verdict {
  std::string file;
  Kind kind = Kind::kConfig;
  std::vector<Diagnostic> mistakes;  // empty: usable
  std::vector<std::string> warnings;
  std::string summary;
  struct Value {
    std::string key, value, origin;
  };
  std::vector<Value> values;  // --show
};

struct Options {
  std::vector<std::string> files;
  std::vector<std::string> overrides;
  double scale = 1;
  bool show = false;
  bool json = false;
};

// "FILE: MESSAGE" or "FILE:LINE:COLUMN: MESSAGE" back in its parts.
Diagnostic as_diagnostic(const std::string& file, std::string_view said) {
  Diagnostic d{file, 0, 0, std::string(said)};
  if (!said.starts_with(file + ":")) return d;
  const std::string rest(said.substr(file.size() + 1));
  int length = 0;
  if (std::sscanf(rest.c_str(), "%d:%d: %n", &d.line, &d.column, &length) < 2 || length == 0) {
    d.line = d.column = 0;
    length = rest.starts_with(' ') ? 1 : 0;
  }
  d.message = rest.substr(static_cast<std::size_t>(length));
  return d;
}

// An error of a library speaks of one file, a line a mistake.
void add_error(Verdict& verdict, const Error& error) {
  std::string_view rest = error.message;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    verdict.mistakes.push_back(as_diagnostic(verdict.file, line));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

// The schema under which fewest keys of the file are unknown at its top level.
Kind kind_of_text(const std::string& text) {
  proto::Config config;
  proto::ObjectFile object;
  proto::HandFile hand;
  const auto strangers = [&text](google::protobuf::Message& message) {
    const auto mistakes = parse_text(text, "", message);
    return std::ranges::count_if(mistakes, [](const Diagnostic& d) {
      return d.message.starts_with("unknown key") && d.message.find("at the top level") != std::string::npos;
    });
  };
  const auto as_config = strangers(config), as_object = strangers(object), as_hand = strangers(hand);
  if (as_config <= as_object && as_config <= as_hand) return Kind::kConfig;
  return as_object <= as_hand ? Kind::kObject : Kind::kHand;
}

// Built-in names first: they need no file.
Kind kind_of(const std::string& file) {
  const auto is_one_of = [&file](const std::vector<std::string>& names) {
    return std::ranges::find(names, file) != names.end();
  };
  std::error_code error;
  if (!fs::exists(file, error)) {
    if (is_one_of(builtin_configs())) return Kind::kConfig;
    if (is_one_of(assets::object_names())) return Kind::kObject;
    if (is_one_of(assets::builtin_hands())) return Kind::kHand;
  }
  if (is_mesh_file(file)) return Kind::kMesh;
  const fs::path path(file);
  if (path.extension() == ".urdf" || path.extension() == ".xacro") return Kind::kHand;
  const auto text = read_file(path);
  return text ? kind_of_text(*text) : Kind::kConfig;
}

std::string plan(const proto::Config& config) {
  const auto listed = static_cast<std::uint32_t>(config.scene().object_size());
  const std::uint32_t wanted = config.scene().objects_in_scene();
  const std::uint32_t present = wanted > 0 ? std::min(wanted, listed) : listed;
  const std::uint64_t targets = config.trials().every_object() ? present : 1;
  const std::uint64_t trials = std::uint64_t{config.trials().scenes()} * config.trials().clicks() * targets;
  const std::uint64_t all = trials * config.neat().population() * config.run().generations();
  return std::to_string(config.neat().population()) + " genomes x " + with_commas(trials) + " trials x " +
         std::to_string(config.run().generations()) + " generations = " + with_commas(all) + " grasps";
}

// A config is usable when its assets load, its fitness makes sense, and a scene can be laid out.
void check_config_file(Verdict& verdict, const Options& options) {
  const auto loaded = load_config(verdict.file, options.overrides, known_names());
  if (!loaded) {
    verdict.mistakes = loaded.error();
    return;
  }
  if (options.show) {
    for (const auto& [key, value] : flatten(loaded->config)) {
      verdict.values.push_back({key, value, origin_name(loaded->origin.at(key))});
    }
  }
  const auto scorer = score::Scorer::create(loaded->config.fitness());
  if (!scorer) return add_error(verdict, scorer.error());
  auto experiment = assets::resolve_experiment(loaded->config, loaded->base);
  if (!experiment) return add_error(verdict, experiment.error());
  verdict.warnings = experiment->warnings;
  const auto simulator =
      sim::Simulator::create(experiment->experiment, experiment->objects, experiment->hand);
  if (!simulator) return add_error(verdict, simulator.error());
  const auto placements = (*simulator)->shuffle(0);
  if (!placements) return add_error(verdict, placements.error());
  verdict.summary = plan(loaded->config);
}

// What a run would say of it later: the simulator has bounds of its own. One object and one hand on a table
// that is large enough.
Status try_out(const proto::ObjectBundle* object, const proto::HandBundle* hand) {
  proto::Config config;
  config.mutable_scene()->add_object("sphere");
  config.mutable_scene()->set_table_half_size(10);
  config.mutable_grasp()->set_hand("parallel_jaw");
  assets::Bundles at_hand;
  if (object != nullptr) at_hand.objects.push_back(*object);
  if (hand != nullptr) at_hand.hand = *hand;
  const auto experiment = assets::resolve_experiment(config, {}, at_hand);
  if (!experiment) return tl::unexpected(experiment.error());
  const auto simulator =
      sim::Simulator::create(experiment->experiment, experiment->objects, experiment->hand);
  if (!simulator) return tl::unexpected(simulator.error());
  return {};
}

void check_object(Verdict& verdict, const Options& options) {
  assets::ObjectOptions how;
  how.mesh_scale = options.scale;
  const auto object = assets::load_object(verdict.file, how);
  if (!object) return add_error(verdict, object.error());
  if (const Status ok = try_out(&object->bundle, nullptr); !ok) return add_error(verdict, ok.error());
  verdict.warnings = object->warnings;
  char text[160];
  std::snprintf(text, sizeof text, "%d convex part%s, %.3g kg, at most %.3g m from its centre of mass",
                object->bundle.part_size(), object->bundle.part_size() == 1 ? "" : "s", object->bundle.mass(),
                object->bundle.torque_scale());
  verdict.summary = text;
}

void check_hand(Verdict& verdict) {
  const auto hand = assets::load_hand(verdict.file, {});
  if (!hand) return add_error(verdict, hand.error());
  if (const Status ok = try_out(nullptr, &hand->bundle); !ok) return add_error(verdict, ok.error());
  verdict.warnings = hand->warnings;
  verdict.summary = std::to_string(hand->bundle.link_size()) + " links, " +
                    std::to_string(hand->bundle.joint_size()) + " joints, " +
                    std::to_string(hand->bundle.motor_size()) + " motors";
}

Verdict judge(const std::string& file, const Options& options) {
  Verdict verdict;
  verdict.file = file;
  verdict.kind = kind_of(file);
  switch (verdict.kind) {
    case Kind::kConfig:
      check_config_file(verdict, options);
      break;
    case Kind::kHand:
      check_hand(verdict);
      break;
    case Kind::kObject:
    case Kind::kMesh:
      check_object(verdict, options);
  }
  return verdict;
}

void print(const Verdict& verdict) {
  for (const std::string& warning : verdict.warnings) warn(verdict.file + ": " + warning);
  for (const Diagnostic& mistake : verdict.mistakes) std::fprintf(stderr, "%s\n", mistake.text().c_str());
  std::size_t key_width = 0, value_width = 0;
  for (const auto& value : verdict.values) {
    key_width = std::max(key_width, value.key.size());
    value_width = std::max(value_width, std::min<std::size_t>(value.value.size(), 40));
  }
  for (const auto& value : verdict.values) {
    std::printf("%-*s  %-*s  %s\n", static_cast<int>(key_width), value.key.c_str(),
                static_cast<int>(value_width), value.value.c_str(), value.origin.c_str());
  }
  if (verdict.mistakes.empty()) {
    std::printf("%s: usable %s (%s)\n", verdict.file.c_str(), kind_name(verdict.kind),
                verdict.summary.c_str());
  }
}

nlohmann::ordered_json as_json(const Verdict& verdict) {
  nlohmann::ordered_json out{
      {"file", verdict.file}, {"kind", kind_name(verdict.kind)}, {"usable", verdict.mistakes.empty()}};
  if (verdict.mistakes.empty()) out["summary"] = verdict.summary;
  out["mistakes"] = nlohmann::ordered_json::array();
  for (const Diagnostic& d : verdict.mistakes) {
    nlohmann::ordered_json mistake{{"message", d.message}};
    if (d.line > 0) mistake.update({{"line", d.line}, {"column", d.column}});
    out["mistakes"].push_back(mistake);
  }
  out["warnings"] = verdict.warnings;
  for (const auto& value : verdict.values) {
    out["values"].push_back({{"key", value.key}, {"value", value.value}, {"origin", value.origin}});
  }
  return out;
}

int validate(const Options& options) {
  auto all = nlohmann::ordered_json::array();
  bool usable = true;
  for (const std::string& file : options.files) {
    const Verdict verdict = judge(file, options);
    usable = usable && verdict.mistakes.empty();
    if (options.json) {
      all.push_back(as_json(verdict));
    } else {
      print(verdict);
    }
  }
  if (options.json) std::cout << all.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
  return usable ? kExitOk : kExitNo;
}

}  // namespace

void add_validate(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub =
      app.add_subcommand("validate", "check configs, objects, hands and meshes; show every setting");
  sub->add_option("file", options->files,
                  "config, object file, hand file, URDF or mesh; or the name of something built in")
      ->required();
  sub->add_flag("--show", options->show,
                "print every value of a config and where it came from (flag, environment, file, default)");
  sub->add_option("--set", options->overrides, "change a value of a config, e.g. neat.population=200")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  sub->add_option("--scale", options->scale, "file units to metres, for mesh files")->capture_default_str();
  sub->add_flag("--json", options->json, "machine-readable");
  sub->footer(
      "Exit code 0: all usable; 1: at least one refused, and why is on standard error.\n\n"
      "Examples:\n"
      "  evograsp validate my.txtpb\n"
      "  EVOGRASP_NEAT__HIDDEN=4 evograsp validate --show quick --set neat.population=200\n"
      "  evograsp validate meshes/*.ply --scale 0.001");
  sub->callback([options, &outcome] { outcome.exit_code = validate(*options); });
}

}  // namespace evograsp::cli

// `evograsp sim`: one trial, looked at closely.
#include <cstdio>
#include <memory>

#include "cli/cli.h"
#include "cli/json_values.h"
#include "cli/output.h"
#include "cli/replay.h"
#include "cli/report.h"
#include "cli/scene_flags.h"
#include "cli/table.h"
#include "score/score.h"
#include "worker/evaluator.h"

namespace evograsp::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  SceneFlags scene;
  bool json = false;
  bool depth = false;
  std::string replay;  // run folder
  std::optional<std::uint64_t> genome;
};

Json placements_json(const Trial& trial) {
  Json out = Json::array();
  const auto& objects = trial.session->experiment().objects;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    Json one;
    one["name"] = objects[i].name();
    one["present"] = trial.placements.present[i] != 0;
    if (trial.placements.present[i]) {
      one.update(to_json(trial.placements.pose[i]));
      one["resting"] = trial.placements.resting[i];
      one["scale"] = trial.placements.scale_of(i);
    }
    out.push_back(std::move(one));
  }
  return out;
}

Json info_json(const sim::Info& info, bool with_depth) {
  Json out;
  out["click"] = {info.click_a, info.click_b};
  out["box"] = {info.box_w, info.box_h};
  out["point"] = to_json(info.point);
  out["anchor"] = to_json(info.anchor);
  if (with_depth) out["depth"] = info.depth;
  return out;
}

Json contacts_json(const sim::GraspReport& report, const proto::HandBundle& hand) {
  Json out = Json::array();
  for (const sim::Contact& contact : report.contacts) {
    Json one;
    one["point"] = to_json(contact.point);
    one["normal"] = to_json(contact.normal);
    one["mu"] = contact.mu;
    one["link"] = contact.link >= 0 && contact.link < hand.link_size() ? hand.link(contact.link).name() : "";
    one["part"] = contact.part;
    one["gap"] = contact.gap;
    out.push_back(std::move(one));
  }
  return out;
}

Json joints_json(const sim::GraspReport& report, const proto::HandBundle& hand) {
  Json out = Json::object();
  for (std::size_t i = 0; i < report.joints.size(); ++i)
    out[hand.joint(static_cast<int>(i)).name()] = report.joints[i];
  return out;
}

Json fitness_json(const score::Terms& terms) {
  return {{"f1", terms.f1}, {"f2", terms.f2}, {"f3", terms.f3}, {"f4", terms.f4}, {"total", terms.total}};
}

void print_vector(const char* label, const Vec3& v) {
  std::printf("  %-22s %9.4f %9.4f %9.4f m\n", label, v.x(), v.y(), v.z());
}

void print_scene(const Options& options, const Trial& trial) {
  const auto& objects = trial.session->experiment().objects;
  std::printf("scene of seed %llu\n", static_cast<unsigned long long>(options.scene.seed));
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (!trial.placements.present[i]) continue;
    const std::string label =
        printable(objects[i].name()) + (static_cast<int>(i) == trial.target ? " (target)" : "");
    print_vector(label.c_str(), trial.placements.pose[i].position);
  }
  if (trial.info) {
    print_vector("clicked point", trial.info->point);
    print_vector("anchor", trial.info->anchor);
  }
}

void print_grasp(const sim::GraspReport& report, const score::Terms& terms, const proto::HandBundle& hand) {
  const sim::Measurement& m = report.measurement;
  std::printf("grasp by %s: %s, %s\n", printable(hand.name()).c_str(), outcome_name(m.outcome),
              m.quality > 0 ? "force closure" : "no force closure");
  std::printf("  %-22s %9.4f\n  %-22s %9d\n  %-22s %9d\n", "quality (epsilon)", m.quality, "contacts",
              m.contacts, "links obstructed", m.obstructions);
  print_vector("asked for", m.p);
  print_vector("reached", m.s);
  print_vector("target's centre", m.o);
  std::printf("  %-22s %9.4f m\n  %-22s %9.4f m\n  %-22s %9.2f deg\n", "to the target", m.target_distance,
              "to the nearest object", m.nearest_object, "theta", m.theta);
  std::printf("  %-22s %9.4f  (f1 %.4f, f2 %.4f, f3 %.4f, f4 %.4f)\n", "fitness", terms.total, terms.f1,
              terms.f2, terms.f3, terms.f4);
  if (report.contacts.empty()) return;
  std::printf("contacts\n");
  for (const sim::Contact& c : report.contacts)
    std::printf("  %-22s %9.4f %9.4f %9.4f m   mu %.2f\n", printable(hand.link(c.link).name()).c_str(),
                c.point.x(), c.point.y(), c.point.z(), c.mu);
}

int run(const Options& options) {
  if (!options.replay.empty()) return replay(options.replay, options.genome, options.json);
  auto trial = prepare_trial(options.scene);
  if (!trial) return report(trial.error());
  const proto::HandBundle& hand = trial->session->experiment().hand;
  Json out;
  out["seed"] = options.scene.seed;
  out["target"] = trial->target;
  out["bounding_box"] = trial->bounding_box;
  out["hand"] = hand.name();
  out["objects"] = placements_json(*trial);
  if (trial->info) out["info"] = info_json(*trial->info, options.depth);
  if (!options.json) print_scene(options, *trial);
  if (trial->tool) {
    auto grasp = trial->session->get_quality(trial->target, *trial->tool);
    if (!grasp) return report(grasp.error());
    auto scorer = score::Scorer::create(trial->config.fitness());
    if (!scorer) return report(scorer.error());
    const score::Terms terms = scorer->trial(worker::to_proto(grasp->measurement));
    out["pose"] = to_json(*trial->tool);
    out["measurement"] = to_json(grasp->measurement);
    out["fitness"] = fitness_json(terms);
    out["palm"] = to_json(grasp->palm);
    out["joints"] = joints_json(*grasp, hand);
    out["contacts"] = contacts_json(*grasp, hand);
    if (!options.json) print_grasp(*grasp, terms, hand);
  }
  if (options.json) print_json(out);
  return kExitOk;
}

}  // namespace

void add_sim(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("sim", "run one trial and print every measurement of it");
  add_scene_flags(*sub, options->scene);
  sub->add_option("--connect", options->scene.connect,
                  "simulate on a worker of this master, step by step, in its experiment")
      ->type_name("ENDPOINT");
  sub->add_option("--curve-key-file", options->scene.key_file,
                  "with --connect: key pair and the master's public key")
      ->type_name("FILE");
  sub->add_flag("--depth", options->depth, "with --json: the depth samples too");
  sub->add_flag("--json", options->json, "machine-readable");
  CLI::Option* replayed =
      sub->add_option("--replay", options->replay,
                      "the trials of a genome that killed or hung workers, as this run kept them")
          ->type_name("RUN");
  sub->add_option("--genome", options->genome, "with --replay: which, when there are several")
      ->needs(replayed);
  sub->footer(
      "Without --pose and --champion the scene is shuffled and looked at, and nothing is grasped.\n\n"
      "Examples:\n"
      "  evograsp sim --seed 7 --object cube --pose \"0.02 0.05 0.06 0 1 0 0.6\"\n"
      "  evograsp sim --seed 7 --object mug,cylinder --target 1 --champion runs/quick --json\n"
      "  evograsp sim --seed 7 --champion runs/quick --connect tcp://127.0.0.1:5555\n"
      "  evograsp sim --replay runs/quick");
  sub->callback([options, &outcome] { outcome.exit_code = run(*options); });
}

}  // namespace evograsp::cli

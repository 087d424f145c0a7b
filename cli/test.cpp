// `evograsp test`: a champion against placements that nobody has trained on.
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/alone.h"
#include "cli/champion_assets.h"
#include "cli/cli.h"
#include "cli/inputs.h"
#include "cli/judge.h"
#include "cli/report.h"
#include "cli/table.h"
#include "common/config.h"

namespace evograsp::cli {
namespace {

struct Options {
  std::string champion;
  std::vector<std::string> objects;
  std::string hand;
  int placements = 100;
  std::uint64_t seed = 1;
  bool box = false, no_box = false;  // neither: as it was trained
  double scale = 0, mass = 0;        // 0: not given
  int threads = 0;
  bool lift = true;
  bool json = false;
};

struct Row {
  std::string object;
  Judgement judgement;
};

Result<std::vector<Row>> judge_all(const proto::Champion& champion, const Options& options, bool box) {
  auto network = Network::from_proto(champion.network());
  if (!network) return tl::unexpected(network.error());
  JudgeOptions how;
  how.placements = options.placements;
  how.seed = options.seed;
  how.bounding_box = box;
  how.lift = options.lift;
  how.threads = options.threads;
  std::vector<std::string> objects = options.objects;
  // Another scale or mass asks for the files again.
  const NamedAssets named{!objects.empty() || options.scale > 0 || options.mass > 0, !options.hand.empty()};
  auto known = trained_bundles(options.champion, champion, named);
  if (!known) return tl::unexpected(known.error());
  assets::Bundles trained = std::move(*known);
  if (named.objects) trained.objects.clear();
  if (named.hand) {
    auto hand = load_hand(options.hand);
    if (!hand) return tl::unexpected(hand.error());
    trained.hand = std::move(*hand);
  }
  if (objects.empty())
    objects.assign(champion.experiment().scene().object().begin(),
                   champion.experiment().scene().object().end());
  // Files that the command names have units of their own.
  const double scale = options.scale > 0 || options.objects.empty() ? options.scale : 1;
  std::vector<Row> rows;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::string& object = objects[i];
    assets::Bundles at_hand{{}, trained.hand};
    if (!trained.objects.empty()) at_hand.objects.push_back(trained.objects.at(i));
    const auto simulator = alone(champion, object, at_hand, scale, options.mass);
    if (!simulator) return tl::unexpected(simulator.error());
    const auto judgement = judge(*network, **simulator, 0, how);
    if (!judgement) return fail(judgement.error().code, object + ": " + judgement.error().message);
    rows.push_back({object, *judgement});
  }
  return rows;
}

std::string rate(int successes, int n) {
  const Interval i = wilson(successes, n);
  char text[64];
  std::snprintf(text, sizeof text, "%5.1f %% (%5.1f to %5.1f)", 100.0 * successes / std::max(1, n),
                100 * i.low, 100 * i.high);
  return text;
}

void print(const std::vector<Row>& rows, const Options& options, bool box) {
  std::size_t width = 6;
  for (const Row& row : rows) width = std::max(width, row.object.size());
  std::printf("%-*s  %-26s", static_cast<int>(width), "object", "stable grasps");
  if (options.lift) std::printf("  %-26s", "lifted and held");
  std::printf("  placements\n");
  Judgement all;
  const auto put = [&](const std::string& name, const Judgement& j) {
    std::printf("%-*s  %-26s", static_cast<int>(width), name.c_str(), rate(j.successes, j.n).c_str());
    if (options.lift) std::printf("  %-26s", rate(j.lifts, j.n).c_str());
    std::printf("  %d\n", j.n);
  };
  for (const Row& row : rows) {
    put(printable(row.object), row.judgement);
    all.n += row.judgement.n;
    all.successes += row.judgement.successes;
    all.lifts += row.judgement.lifts;
  }
  if (rows.size() > 1) put("all", all);
  std::printf("\nNovel placements, %s bounding box; in brackets the 95 %% confidence interval.\n",
              box ? "with" : "without");
}

nlohmann::ordered_json as_json(const std::vector<Row>& rows, const Options& options, bool box) {
  nlohmann::ordered_json out{{"champion", options.champion}, {"seed", options.seed}, {"bounding_box", box}};
  out["objects"] = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    const Judgement& j = row.judgement;
    const Interval grasped = wilson(j.successes, j.n), lifted = wilson(j.lifts, j.n);
    nlohmann::ordered_json object{{"object", row.object},
                                  {"n", j.n},
                                  {"success", j.success()},
                                  {"successes", j.successes},
                                  {"success_interval", {grasped.low, grasped.high}}};
    if (options.lift) {
      object.update({{"lift_success", j.lift_success()},
                     {"lifts", j.lifts},
                     {"lift_interval", {lifted.low, lifted.high}}});
    }
    object["unseen"] = j.unseen;
    out["objects"].push_back(object);
  }
  return out;
}

int test(const Options& options) {
  const auto champion = read_champion(options.champion);
  if (!champion) return report(champion.error());
  const bool box = options.box || (champion->experiment().trials().bounding_box() && !options.no_box);
  const auto rows = judge_all(*champion, options, box);
  if (!rows) return report(rows.error());
  if (options.json) {
    std::cout << as_json(*rows, options, box).dump(2, ' ', false, nlohmann::json::error_handler_t::replace)
              << "\n";
  } else {
    print(*rows, options, box);
  }
  return kExitOk;
}

}  // namespace

void add_test(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub =
      app.add_subcommand("test", "how often does a champion grasp in placements it has never met?");
  sub->add_option("champion", options->champion, "champion.pb, or the run folder that holds it")->required();
  sub->add_option("--objects", options->objects,
                  "built-in names, object files or meshes, with commas [those it was trained on]")
      ->type_name("LIST")
      ->delimiter(',');
  sub->add_option("--hand", options->hand, "name or hand file [the one it was trained with]");
  sub->add_option("--placements", options->placements, "random placements an object")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  auto* box = sub->add_flag("--box", options->box, "through the bounding-box window [as it was trained]");
  sub->add_flag("--no-box", options->no_box, "on the whole image, absolute positions")->excludes(box);
  sub->add_option("--seed", options->seed, "seed of the placements")->type_name("S")->capture_default_str();
  sub->add_option("--scale", options->scale, "file units to metres, for mesh files [1]")
      ->type_name("X")
      ->check(CLI::PositiveNumber);
  sub->add_option("--mass", options->mass, "mass of mesh files in kg [by density]")
      ->type_name("KG")
      ->check(CLI::PositiveNumber);
  sub->add_option("--threads", options->threads, "placements at once; 0: one a core; the answer is the same")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  sub->add_flag("!--no-lift", options->lift, "skip the lift test");
  sub->add_flag("--json", options->json, "machine-readable");
  sub->footer(
      "A stable grasp is one in force closure. The lift test is stricter: the hand closes with the torque "
      "its motors\n"
      "have, lifts the object 10 cm, holds it for a second and shakes it.\n\n"
      "Examples:\n"
      "  evograsp test runs/quick/champion.pb\n"
      "  evograsp test runs/mug --objects mug,plated_mug --placements 200 --no-box\n"
      "  evograsp test runs/mesh --objects bottle.ply --scale 0.001 --json");
  sub->callback([options, &outcome] { outcome.exit_code = test(*options); });
}

}  // namespace evograsp::cli

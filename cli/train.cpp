// `evograsp train`: one run on this machine.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/cli.h"
#include "cli/inputs.h"
#include "cli/local_run.h"
#include "cli/output.h"
#include "cli/program.h"
#include "cli/progress.h"
#include "cli/report.h"
#include "cli/run_folder.h"
#include "cli/stop_signals.h"
#include "common/config.h"
#include "common/log.h"
#include "common/mutex.h"
#include "common/near_miss.h"

namespace evograsp::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string config;
  std::string out;
  std::string resume;
  std::string objects_from;
  std::vector<std::string> overrides;
  std::optional<std::uint64_t> seed;
  double scale = 0, mass = 0;  // 0: as the config says
  int slots = 0;
  bool quiet = false;
  bool json = false;
};

std::string shortest(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

// --objects-from: every mesh and object file of a folder in the place of the config's objects, one at a time
// on the table unless --set says otherwise.
Status add_objects(const Options& options, std::vector<std::string>& overrides) {
  if (options.objects_from.empty()) return {};
  const auto files = objects_in(options.objects_from);
  if (!files) return tl::unexpected(files.error());
  std::string list;
  for (const std::string& file : *files) list += (list.empty() ? "" : ", ") + nlohmann::json(file).dump();
  overrides.push_back("scene.object=[" + list + "]");
  overrides.push_back("scene.objects_in_scene=1");
  return {};
}

Result<std::vector<std::string>> all_overrides(const Options& options) {
  std::vector<std::string> overrides;
  if (auto status = add_objects(options, overrides); !status) return tl::unexpected(status.error());
  if (options.seed) overrides.push_back("run.seed=" + std::to_string(*options.seed));
  if (options.scale > 0) overrides.push_back("scene.mesh_scale=" + shortest(options.scale));
  if (options.mass > 0) overrides.push_back("scene.mesh_mass=" + shortest(options.mass));
  overrides.insert(overrides.end(), options.overrides.begin(), options.overrides.end());
  return overrides;
}

// What the server needs for a new run; the exit code when it cannot be had.
tl::expected<server::ServerOptions, int> prepare_new(const Options& options) {
  const auto overrides = all_overrides(options);
  if (!overrides) return tl::unexpected(report(overrides.error()));
  auto loaded = load_config(options.config, *overrides, known_names());
  if (!loaded) return tl::unexpected(report(loaded.error()));
  const fs::path folder = options.out.empty() ? fresh_folder(fs::path("runs") / loaded->config.run().name())
                                              : fs::path(options.out);
  auto prepared = new_run(std::move(*loaded), folder);
  if (!prepared) return tl::unexpected(report(prepared.error()));
  return std::move(*prepared);
}

tl::expected<server::ServerOptions, int> prepare_resumed(const Options& options) {
  auto prepared = resumed_run(options.resume);
  if (!prepared) return tl::unexpected(report(prepared.error()));
  return std::move(*prepared);
}

// The run itself, with its progress, signals on a thread of their own, and what is left in its folder.
class Training {
 public:
  Training(const Options& options, server::ServerOptions server)
      : options_(options), server_options_(std::move(server)) {}
  int run();

 private:
  Result<server::RunState> evolve();
  void interrupt();
  int conclude(server::RunState state);
  void show_result(const RunFolder& run);
  void show_json(const RunFolder& run);

  const Options& options_;
  const server::ServerOptions server_options_;
  std::unique_ptr<LocalRun> run_;
  Mutex mutex_;
  LocalRun* under_way_ GUARDED_BY(mutex_) = nullptr;
  StopSignals signals_;
};

// On the signals' thread. Until the run is under way there is nothing to commit.
void Training::interrupt() {
  const MutexLock lock(mutex_);
  if (under_way_ == nullptr) end_now();
  std::fputs("\nstopping: what is done gets committed (Ctrl-C again: stop at once)\n", stderr);
  under_way_->stop();
}

Result<server::RunState> Training::evolve() {
  signals_.watch([this] { interrupt(); });
  auto run = LocalRun::create(server_options_, options_.slots);
  if (!run) return tl::unexpected(run.error());
  run_ = std::move(*run);
  if (!options_.quiet) {
    std::fprintf(stderr, "%s %s in %s\n", options_.resume.empty() ? "training" : "resuming",
                 server_options_.config.run().name().c_str(), server_options_.run_dir.c_str());
  }
  Progress progress(options_.quiet ? ProgressStyle::kSilent : progress_style(stderr),
                    server_options_.config.run().generations());
  {
    const MutexLock lock(mutex_);
    under_way_ = run_.get();
  }
  auto state = run_->run([&progress](const server::GenerationReport& report) { progress.show(report); });
  progress.finish();
  signals_.stop();
  run_.reset();
  return state;
}

int Training::run() {
  // The progress line says what goes well; the worker taking its leave is no news.
  set_up_logging({.json = false, .level = spdlog::level::err});
  const auto state = evolve();
  if (!state) return report(state.error());
  return conclude(*state);
}

// grasp.png, by the program's own render command.
void draw_grasp(const fs::path& folder) {
  Outcome outcome;
  const auto app = make_app(outcome);
  const auto is_render = [](const CLI::App* command) { return command->get_name() == "render"; };
  if (std::ranges::none_of(app->get_subcommands({}), is_render)) return;
  const std::string champion = (folder / "champion.pb").string(), picture = (folder / "grasp.png").string();
  const char* const command[] = {"evograsp", "render",        "--champion", champion.c_str(),
                                 "--out",    picture.c_str(), "--size",     "960x720"};
  if (cli::run(static_cast<int>(std::size(command)), command) != kExitOk) warn(picture + ": not drawn");
}

int Training::conclude(server::RunState state) {
  const auto run = read_run_folder(server_options_.run_dir);
  if (!run) return report(run.error());
  if (run->champion) draw_grasp(run->path);
  if (auto status = write_results(*run); !status) return report(status.error());
  if (state == server::RunState::kFailed) {
    return report(Error{ErrorCode::kInternal, run->path.string() + ": the run failed; its log says why"});
  }
  if (options_.json) {
    show_json(*run);
  } else if (!options_.quiet) {
    show_result(*run);
  }
  if (state == server::RunState::kFinished) return kExitOk;
  std::fprintf(stderr, "stopped after generation %zu of %u; go on with:\n  evograsp train --resume %s\n",
               run->generations.size(), run->info.config.run().generations(), run->path.c_str());
  return kExitInterrupted;
}

void Training::show_result(const RunFolder& run) {
  std::printf("\n%s", to_text(run.plot(), plot_columns(terminal_size(stdout).columns)).c_str());
  if (!run.generations.empty()) {
    const server::GenerationRecord& last = run.generations.back();
    std::printf("\n%s grasps in %s, %s a second\n", with_commas(last.trials).c_str(),
                duration(last.seconds).c_str(),
                with_commas(static_cast<std::uint64_t>(static_cast<double>(last.trials) /
                                                       std::max(1e-9, last.seconds)))
                    .c_str());
  }
  if (!run.champion) return;
  const proto::Champion& champion = *run.champion;
  std::printf("champion: bred in generation %u; grasps %u of %u placements it was never trained on\n",
              champion.generation(), champion.validation_successes(), champion.validation_trials());
  const std::string folder = run.path.string();
  std::printf(
      "\nNext:\n  evograsp test %s\n  evograsp render --champion %s --out grasp.png --seed 2\n  xdg-open "
      "%s/report.html\n",
      folder.c_str(), folder.c_str(), folder.c_str());
}

void Training::show_json(const RunFolder& run) {
  nlohmann::ordered_json out{
      {"out", run.path.string()}, {"state", run.state}, {"generations", run.generations.size()}};
  if (!run.generations.empty()) {
    const server::GenerationRecord& last = run.generations.back();
    out.update(
        {{"trials", last.trials}, {"seconds", last.seconds}, {"best", last.best}, {"mean", last.mean}});
  }
  if (run.champion) {
    const proto::Champion& c = *run.champion;
    out["champion"] = {{"generation", c.generation()},
                       {"fitness", c.fitness()},
                       {"validation_trials", c.validation_trials()},
                       {"validation_successes", c.validation_successes()},
                       {"validation_fitness", c.validation_fitness()}};
  }
  std::cout << out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
}

int train(const Options& options) {
  if (options.config.empty() == options.resume.empty()) {
    return report(Error{ErrorCode::kUsage, "train: give a CONFIG, or --resume DIR"});
  }
  if (!options.resume.empty() &&
      (!options.overrides.empty() || options.seed || !options.objects_from.empty())) {
    return report(
        Error{ErrorCode::kUsage,
              "train: --resume continues a run as it was begun: no --set, --seed or --objects-from"});
  }
  auto prepared = options.resume.empty() ? prepare_new(options) : prepare_resumed(options);
  if (!prepared) return prepared.error();
  return Training(options, std::move(*prepared)).run();
}

}  // namespace

void add_train(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("train", "evolve a grasp controller on this machine");
  const std::vector<std::string> names = builtin_configs();
  sub->add_option("config", options->config,
                  "config file, or a built-in one: " + join_words(names, names.size()));
  sub->add_option("--out", options->out, "run folder to make [runs/NAME, numbered when taken]")
      ->type_name("DIR");
  sub->add_option("--resume", options->resume, "go on with the run in this folder, to the same bytes")
      ->type_name("DIR");
  sub->add_option("--slots", options->slots, "simulators at work at once; 0: one a core")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  sub->add_option("--seed", options->seed, "the run's seed: the same seed gives the same champion")
      ->type_name("S");
  sub->add_option("--set", options->overrides,
                  "change a value of the config, e.g. neat.population=200 (may be repeated)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  sub->add_option("--objects-from", options->objects_from, "train on every mesh and object file of a folder")
      ->type_name("DIR");
  sub->add_option("--scale", options->scale, "with meshes: file units to metres")
      ->type_name("X")
      ->check(CLI::PositiveNumber);
  sub->add_option("--mass", options->mass, "with meshes: mass in kg, in the place of density")
      ->type_name("KG")
      ->check(CLI::PositiveNumber);
  sub->add_flag("-q,--quiet", options->quiet, "no progress, no plot");
  sub->add_flag("--json", options->json, "print the result machine-readable");
  sub->footer(
      "The folder gets run.db (everything, resumable), champion.pb, fitness.png, grasp.png and report.html.\n"
      "Ctrl-C commits what is done and says how to go on (exit code 130).\n\n"
      "Examples:\n"
      "  evograsp train quick\n"
      "  evograsp train cube --out runs/cube --seed 7 --set neat.hidden=4\n"
      "  evograsp train mesh --objects-from meshes/ --scale 0.001\n"
      "  evograsp train --resume runs/cube");
  sub->callback([options, &outcome] { outcome.exit_code = train(*options); });
}

}  // namespace evograsp::cli

// `evograsp experiment`: a study of many runs, from its matrix to its page.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>

#include "cli/cli.h"
#include "cli/inputs.h"
#include "cli/output.h"
#include "cli/report.h"
#include "cli/stop_signals.h"
#include "cli/study/report.h"
#include "cli/study/runner.h"
#include "cli/table.h"
#include "common/log.h"

namespace evograsp::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string study;
  std::string out;
  study::Selection selection;
  std::string objects_from;
  double scale = 0, mass = 0;
  int slots = 0;
  bool list = false;
  bool plan = false;
  bool quiet = false;
  bool json = false;
};

int list_studies(const Options& options) {
  Table table({{"study"}, {"runs", Align::kRight}, {"asks"}});
  auto json = nlohmann::ordered_json::array();
  for (const std::string& name : study::builtin_studies()) {
    const auto loaded = study::load_study(name);
    if (!loaded) return report(loaded.error());
    const auto runs = study::plan(*loaded, options.selection);
    if (!runs) return report(runs.error());
    table.add({name, std::to_string(runs->size()), loaded->study.title()});
    json.push_back({{"study", name}, {"runs", runs->size()}, {"title", loaded->study.title()}});
  }
  options.json ? print_json(json) : print(table.text());
  return kExitOk;
}

int show_plan(const std::vector<study::PlannedRun>& runs, const Options& options) {
  auto json = nlohmann::ordered_json::array();
  for (const study::PlannedRun& run : runs) {
    std::string line = run.id + ": " + run.config;
    for (const std::string& value : run.overrides) line += " --set " + value;
    if (!options.json) print(line + "\n");
    json.push_back(
        {{"run", run.id}, {"config", run.config}, {"set", run.overrides}, {"tested_on", run.test_objects}});
  }
  if (options.json) print_json(json);
  return kExitOk;
}

// Meshes and object files of a folder and of the folders in it, one level down.
Result<std::vector<std::string>> objects_below(const fs::path& folder) {
  std::vector<std::string> found;
  std::error_code error;
  if (const auto here = objects_in(folder)) found = *here;
  std::vector<fs::path> inner;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->is_directory(error)) inner.push_back(it->path());
  std::ranges::sort(inner);
  for (const fs::path& path : inner)
    if (const auto there = objects_in(path)) found.insert(found.end(), there->begin(), there->end());
  if (found.empty())
    return fail(ErrorCode::kNotFound, folder.string() + ": no mesh and no object file in it");
  return found;
}

// As typed, but for the folder, which is the reader's.
std::string command_line(const Options& options) {
  std::string line = "evograsp experiment " + options.study;
  if (options.selection.seeds > 0) line += " --seeds " + std::to_string(options.selection.seeds);
  for (const std::string& only : options.selection.only) line += " --only " + only;
  for (const std::string& value : options.selection.overrides) line += " --set '" + value + "'";
  if (!options.objects_from.empty())
    line += " --objects-from " + fs::path(options.objects_from).filename().string() + "/";
  if (options.slots > 0) line += " --slots " + std::to_string(options.slots);
  return line;
}

class Experiment {
 public:
  Experiment(const Options& options, study::LoadedStudy study, std::vector<study::PlannedRun> plan)
      : options_(options),
        study_(std::move(study)),
        plan_(std::move(plan)),
        out_(options.out.empty() ? fs::path("experiments") / study_.name : fs::path(options.out)),
        progress_(options.quiet ? ProgressStyle::kSilent : progress_style(stderr)) {}
  int run();

 private:
  int conclude(const std::vector<study::DoneRun>& done);
  void show(const study::Data& data);

  const Options& options_;
  const study::LoadedStudy study_;
  const std::vector<study::PlannedRun> plan_;
  const fs::path out_;
  study::StudyProgress progress_;
  StopSignals signals_;
};

int Experiment::run() {
  set_up_logging({.json = false, .level = spdlog::level::err});
  study::RunnerOptions how{out_, options_.slots, {}, options_.scale, options_.mass};
  if (study_.study.test().folder()) {
    if (options_.objects_from.empty())
      return report(Error{ErrorCode::kUsage,
                          study_.name + " tests on the meshes of a folder: name it by --objects-from"});
    auto objects = objects_below(options_.objects_from);
    if (!objects) return report(objects.error());
    how.folder_objects = std::move(*objects);
  }
  study::Runner runner(study_, std::move(how), progress_);
  if (auto prepared = runner.prepare(plan_); !prepared) return report(prepared.error());
  std::error_code error;
  fs::create_directories(out_, error);
  if (error) return report(Error{ErrorCode::kIo, out_.string() + ": cannot be made: " + error.message()});
  signals_.watch([&runner] {
    std::fputs("\nstopping: what is done gets committed (Ctrl-C again: stop at once)\n", stderr);
    runner.stop();
  });
  const auto done = runner.run_all();
  signals_.stop();
  if (!done) return report(done.error());
  return conclude(*done);
}

int Experiment::conclude(const std::vector<study::DoneRun>& done) {
  const study::Data data = study::collect(study_.study, done);
  const study::Report what{out_, command_line(options_), plan_.size()};
  if (auto status = study::write_report(study_, data, what); !status) return report(status.error());
  show(data);
  if (done.size() == plan_.size()) return kExitOk;
  say("stopped after " + std::to_string(done.size()) + " of " + std::to_string(plan_.size()) +
      " runs; the same command goes on with it");
  return kExitInterrupted;
}

void Experiment::show(const study::Data& data) {
  if (options_.json) {
    nlohmann::ordered_json out{{"study", study_.name},
                               {"out", out_.string()},
                               {"runs", data.runs.rows.size()},
                               {"planned", plan_.size()},
                               {"tables", nlohmann::ordered_json::object()}};
    for (const proto::StudyTable& table : study_.study.table())
      out["tables"][table.name()] = study::to_json(study::sum_up(table, data).data);
    return print_json(out);
  }
  if (options_.quiet) return;
  for (const proto::StudyTable& spec : study_.study.table()) {
    const study::DataTable summed = study::sum_up(spec, data).data;
    std::vector<Table::Column> columns;
    for (std::size_t i = 0; i < summed.columns.size(); ++i)
      columns.push_back(
          {summed.columns[i], i < static_cast<std::size_t>(spec.by_size()) ? Align::kLeft : Align::kRight});
    Table table(columns);
    for (const auto& row : summed.rows) {
      std::vector<std::string> cells;
      for (const study::Cell& cell : row)
        cells.push_back(cell.is_number_float() ? fixed(cell.get<double>(), 3) : study::text_of(cell));
      table.add(std::move(cells));
    }
    print(spec.title() + "\n\n" + table.text() + "\n");
  }
  print("Written: " + (out_ / "report.html").string() + ", README.md, plots and data beside it\n");
}

int experiment(Options& options) {
  options.selection.cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  if (options.list) return list_studies(options);
  if (options.study.empty())
    return report(Error{ErrorCode::kUsage, "experiment: give the name of a STUDY or its file, or --list"});
  auto loaded = study::load_study(options.study);
  if (!loaded) return report(loaded.error());
  auto plan = study::plan(*loaded, options.selection);
  if (!plan) return report(plan.error());
  if (options.plan) return show_plan(*plan, options);
  return Experiment(options, std::move(*loaded), std::move(*plan)).run();
}

}  // namespace

void add_experiment(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub =
      app.add_subcommand("experiment", "run a study: many runs, their tests, tables, plots and a page");
  sub->add_option("study", options->study, "name of a study (--list), or a study's file");
  sub->add_flag("--list", options->list, "the studies that come with the program");
  sub->add_flag("--plan", options->plan, "print the runs that the study consists of, and run nothing");
  sub->add_option("--out", options->out,
                  "folder of the study; the same one goes on with it [experiments/NAME]")
      ->type_name("DIR");
  sub->add_option("--seeds", options->selection.seeds, "seeds 1 to N of each setting [as the study says]")
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  sub->add_option("--only", options->selection.only,
                  "leave out the other values of an axis (may be repeated)")
      ->type_name("AXIS=VALUE,...")
      ->allow_extra_args(false);
  sub->add_option("--set", options->selection.overrides,
                  "change a value of every run's config (may be repeated)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  sub->add_option("--objects-from", options->objects_from, "with studies that test on the meshes of a folder")
      ->type_name("DIR");
  sub->add_option("--scale", options->scale, "file units to metres, for these meshes [1]")
      ->type_name("X")
      ->check(CLI::PositiveNumber);
  sub->add_option("--mass", options->mass, "mass of these meshes in kg [by density]")
      ->type_name("KG")
      ->check(CLI::PositiveNumber);
  sub->add_option("--slots", options->slots, "simulators at work at once; 0: one a core")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  sub->add_flag("-q,--quiet", options->quiet, "no progress, no tables");
  sub->add_flag("--json", options->json, "print the tables machine-readable");
  sub->footer(
      "The folder gets README.md and report.html (the page), plots as SVG and PNG, tables as CSV and JSON, "
      "and a\n"
      "folder a run below runs/. Ctrl-C commits what is done (exit code 130); the same command goes on with "
      "it, and\n"
      "repeats nothing. A study is a text file: docs/EXPERIMENTS.md shows how to write one.\n\n"
      "Examples:\n"
      "  evograsp experiment --list\n"
      "  evograsp experiment bounding-box\n"
      "  evograsp experiment generality --seeds 2 --only class=cube --out look\n"
      "  evograsp experiment meshes --objects-from meshes/ --scale 0.001\n"
      "  evograsp experiment my-study.txtpb --plan");
  sub->callback([options, &outcome] { outcome.exit_code = experiment(*options); });
}

}  // namespace evograsp::cli

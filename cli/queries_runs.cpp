// `evograsp runs`: what runs there are in a folder.
#include <algorithm>
#include <filesystem>
#include <system_error>

#include "cli/output.h"
#include "cli/progress.h"
#include "cli/queries.h"
#include "cli/table.h"
#include "server/store.h"

namespace evograsp::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kDeepest = 4;  // folders below the one named

struct RunsOptions {
  std::string folder = ".";
  bool json = false;
};

std::vector<fs::path> find_runs(const fs::path& root) {
  std::vector<fs::path> found;
  std::error_code problem;
  if (fs::exists(root / server::kStoreFile, problem)) found.push_back(root);
  fs::recursive_directory_iterator it(root, fs::directory_options::skip_permission_denied, problem), end;
  while (!problem && it != end) {
    if (it.depth() >= kDeepest) it.disable_recursion_pending();
    std::error_code ignored;
    if (it->is_directory(ignored) && fs::exists(it->path() / server::kStoreFile, ignored))
      found.push_back(it->path());
    it.increment(problem);
  }
  std::ranges::sort(found);
  return found;
}

json describe(const fs::path& folder) {
  const auto source = Source::open({"", folder.string(), false});
  const auto run = source ? (*source)->run() : Result<json>(tl::unexpected(source.error()));
  if (run) return *run;
  return {{"folder", folder.string()}, {"state", "unreadable"}, {"error", run.error().message}};
}

int runs(const RunsOptions& options) {
  std::error_code problem;
  if (!fs::is_directory(options.folder, problem))
    return report(Error{ErrorCode::kNotFound, options.folder + ": no such folder"});
  json all = json::array();
  for (const fs::path& folder : find_runs(options.folder)) all.push_back(describe(folder));
  if (options.json) return print_json(json{{"runs", all}}), kExitOk;
  Table table({{"folder"},
               {"run"},
               {"state"},
               {"generation", Align::kRight},
               {"best", Align::kRight},
               {"trials", Align::kRight},
               {"took", Align::kRight}});
  for (const json& run : all) {
    if (text_in(run, "state") == "unreadable") {
      table.add({text_in(run, "folder"), "", "unreadable"});
      warn(text_in(run, "error"));
      continue;
    }
    table.add(
        {text_in(run, "folder"), text_in(run, "name"), text_in(run, "state"),
         std::to_string(count_in(run, "committed")) + "/" + std::to_string(count_in(run, "generations")),
         fixed(number_in(part_in(run, "fitness"), "best_ever")), with_commas(count_in(run, "trials")),
         duration(number_in(run, "seconds"))});
  }
  if (table.empty())
    return say(options.folder + ": no run here; start one with: evograsp train quick"), kExitOk;
  print(table.text());
  return kExitOk;
}

}  // namespace

void add_runs(CLI::App& app, Outcome& outcome) {
  const auto options = std::make_shared<RunsOptions>();
  CLI::App* sub = app.add_subcommand("runs", "the runs in a folder: state, generation, best fitness");
  sub->add_option("dir", options->folder, "where to look, and in the folders below")->capture_default_str();
  sub->add_flag("--json", options->json, "machine-readable");
  sub->footer(
      "An interrupted run can go on: its server is gone, its last generation is safe.\n\n"
      "Examples:\n  evograsp runs\n  evograsp runs runs --json | jq -r '.runs[] | select(.state == "
      "\"interrupted\").folder'");
  sub->callback([options, &outcome] { outcome.exit_code = runs(*options); });
}

}  // namespace evograsp::cli

// `evograsp workers`, `generations`, `species`, `events` and `history`.
#include <cmath>
#include <ctime>

#include "cli/output.h"
#include "cli/plot.h"
#include "cli/progress.h"
#include "cli/queries.h"
#include "cli/table.h"

namespace evograsp::cli {
namespace {

using nlohmann::json;

struct ListOptions {
  SourceOptions source;
  std::uint32_t last = 20;
  std::optional<std::uint32_t> generation;
  bool csv = false;
};

std::string count_text(const json& row, const char* key) {
  return with_commas(count_in(row, key));
}

std::string rate_text(const json& worker) {
  const double rate = number_in(worker, "trials_per_second");
  return rate >= 0 && rate < 1e15 ? with_commas(static_cast<std::uint64_t>(std::llround(rate))) : "-";
}

std::string clock_time(double unix_seconds) {
  if (!(std::abs(unix_seconds) < 1e12)) return "-";
  const auto whole = static_cast<std::time_t>(unix_seconds);
  std::tm parts{};
  char text[32];
  if (::localtime_r(&whole, &parts) == nullptr || std::strftime(text, sizeof text, "%F %T", &parts) == 0)
    return "-";
  return text;
}

int workers(Source& source, const ListOptions& options) {
  const auto document = source.workers();
  if (!document) return report(document.error());
  if (options.source.json) return print_json(*document), kExitOk;
  Table table({{"worker"},
               {"host"},
               {"build"},
               {"state"},
               {"slots", Align::kRight},
               {"busy", Align::kRight},
               {"tasks", Align::kRight},
               {"trials", Align::kRight},
               {"trials/s", Align::kRight},
               {"heard", Align::kRight}});
  for (const json& w : rows_in(*document, "workers"))
    table.add({text_in(w, "identity"), text_in(w, "host"), text_in(w, "build"), text_in(w, "state"),
               count_text(w, "slots"), count_text(w, "busy"), count_text(w, "tasks"), count_text(w, "trials"),
               rate_text(w), duration(number_in(w, "silent_seconds")) + " ago"});
  if (table.empty())
    return say("no worker yet; start one with: evograsp-worker --connect tcp://HOST:5555"), kExitOk;
  print(table.text());
  return kExitOk;
}

int generations(Source& source, const ListOptions& options) {
  const auto run = source.run();
  if (!run) return report(run.error());
  const std::uint64_t committed = count_in(*run, "committed");
  const auto first = static_cast<std::uint32_t>(committed > options.last ? committed - options.last : 0);
  const auto document = source.all_generations(options.last == 0 ? 0 : first);
  if (!document) return report(document.error());
  if (options.source.json) return print_json(*document), kExitOk;
  Table table({{"generation", Align::kRight},
               {"best", Align::kRight},
               {"mean", Align::kRight},
               {"deviation", Align::kRight},
               {"species", Align::kRight},
               {"threshold", Align::kRight},
               {"links", Align::kRight},
               {"trials", Align::kRight},
               {"seconds", Align::kRight}});
  for (const json& g : rows_in(*document, "generations"))
    table.add({count_text(g, "generation"), fixed(number_in(g, "best")), fixed(number_in(g, "mean")),
               fixed(number_in(g, "deviation")), count_text(g, "species"),
               fixed(number_in(g, "threshold"), 2), fixed(number_in(g, "links"), 1), count_text(g, "trials"),
               fixed(number_in(g, "seconds"), 2)});
  if (table.empty()) return say("no generation has been judged yet"), kExitOk;
  print(table.text());
  return kExitOk;
}

int species(Source& source, const ListOptions& options) {
  const auto document = source.species(options.generation);
  if (!document) return report(document.error());
  if (options.source.json) return print_json(*document), kExitOk;
  Table table({{"species", Align::kRight},
               {"size", Align::kRight},
               {"age", Align::kRight},
               {"improved", Align::kRight},
               {"best", Align::kRight},
               {"mean", Align::kRight}});
  for (const json& s : rows_in(*document, "species"))
    table.add({std::to_string(count_in(s, "id")), count_text(s, "size"), count_text(s, "age"),
               count_text(s, "last_improved"), fixed(number_in(s, "best")), fixed(number_in(s, "mean"))});
  print("generation " + std::to_string(count_in(*document, "generation")) + "\n" + table.text());
  return kExitOk;
}

int events(Source& source, const ListOptions& options) {
  const auto document = source.events(0, std::min(options.last == 0 ? kPage : options.last, kPage));
  if (!document) return report(document.error());
  if (options.source.json) return print_json(*document), kExitOk;
  Table table({{"time"}, {"severity"}, {"kind"}, {"what"}});
  for (const json& e : rows_in(*document, "events"))
    table.add(
        {clock_time(number_in(e, "time")), text_in(e, "severity"), text_in(e, "kind"), text_in(e, "text")});
  if (table.empty()) return say("nothing has happened yet"), kExitOk;
  print(table.text());
  return kExitOk;
}

constexpr const char* kCsvColumns[] = {"generation",  "best",      "mean",        "deviation",
                                       "species",     "threshold", "best_genome", "links",
                                       "evaluations", "trials",    "seconds",     "committed_at"};

std::string csv_text(const json& generations) {
  std::string out;
  for (const char* column : kCsvColumns) out += (out.empty() ? "" : ",") + std::string(column);
  out += "\n";
  for (const json& g : generations) {
    for (const char* column : kCsvColumns) {
      if (column != kCsvColumns[0]) out += ",";
      const json& value = part_in(g, column);
      if (value.is_number()) out += value.dump();  // shortest text that reads back to the same
    }
    out += "\n";
  }
  return out;
}

int history(Source& source, const ListOptions& options) {
  const auto document = source.all_generations(0);
  if (!document) return report(document.error());
  const json all = rows_in(*document, "generations");
  if (options.source.json) return print_json(*document), kExitOk;
  if (options.csv) return print(csv_text(all)), kExitOk;
  FitnessPlot plot;
  for (const json& g : all)
    plot.points.push_back({static_cast<std::uint32_t>(count_in(g, "generation")), number_in(g, "best"),
                           number_in(g, "mean"), static_cast<std::uint32_t>(count_in(g, "species"))});
  print(to_text(plot, plot_columns(terminal_size(stdout).columns)));
  return kExitOk;
}

CLI::App* add_list(CLI::App& app, Outcome& outcome, const char* name, const char* description,
                   const char* footer, int (*answer)(Source&, const ListOptions&),
                   std::shared_ptr<ListOptions>& options) {
  options = std::make_shared<ListOptions>();
  CLI::App* sub = app.add_subcommand(name, description);
  add_source_options(*sub, options->source);
  sub->footer(footer);
  answer_with_source(*sub, options, outcome, answer);
  return sub;
}

}  // namespace

void add_lists(CLI::App& app, Outcome& outcome) {
  std::shared_ptr<ListOptions> options;
  add_list(app, outcome, "workers", "who is working, how fast, and who was last heard when",
           "Examples:\n  evograsp workers\n  evograsp workers --json | jq '.workers[] | select(.state == "
           "\"gone\")'",
           workers, options);
  CLI::App* sub =
      add_list(app, outcome, "generations", "the judged generations: fitness, species, time",
               "Examples:\n  evograsp generations --last 5\n  evograsp generations --run runs/quick --last 0",
               generations, options);
  sub->add_option("--last", options->last, "so many of the newest (0: all)")->capture_default_str();
  sub = add_list(app, outcome, "species", "the species of a generation",
                 "Examples:\n  evograsp species\n  evograsp species --run runs/quick --generation 12",
                 species, options);
  sub->add_option("--generation", options->generation, "which one (default: the last judged)");
  sub = add_list(app, outcome, "events", "what happened: workers, faults, resumes",
                 "Example:\n  evograsp events --run runs/quick --last 50", events, options);
  sub->add_option("--last", options->last, "so many of the newest (0: as many as are given at once)")
      ->capture_default_str();
  sub = add_list(app, outcome, "history", "the whole course of a run: a picture, or every number as CSV",
                 "Examples:\n  evograsp history --run runs/quick\n  evograsp history --csv > history.csv",
                 history, options);
  sub->add_flag("--csv", options->csv, "every generation and every number, for other programs");
}

}  // namespace evograsp::cli

// `evograsp status` and `evograsp watch`.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "cli/output.h"
#include "cli/plot.h"
#include "cli/progress.h"
#include "cli/queries.h"
#include "cli/table.h"

namespace evograsp::cli {
namespace {

using nlohmann::json;

constexpr std::uint32_t kSparkGenerations = 1000;  // the newest ones that the little picture shows
constexpr std::size_t kSparkWidth = 32;
constexpr std::uint32_t kWatchedEvents = 5;

struct StatusOptions {
  SourceOptions source;
};
struct WatchOptions {
  SourceOptions source;
  double interval = 1;
  std::uint64_t count = 0;  // 0: to the end of the run
};

// A run as a person wants to see it, gathered in a few questions.
struct View {
  json run;
  json generations = json::array();  // all of them when watching, else the newest
  json workers = json::array();
  json events = json::array();
};

Result<View> look_once(Source& source) {
  View view;
  auto run = source.run();
  if (!run) return tl::unexpected(run.error());
  view.run = std::move(*run);
  const std::uint64_t committed = count_in(view.run, "committed");
  const auto from =
      static_cast<std::uint32_t>(committed > kSparkGenerations ? committed - kSparkGenerations : 0);
  auto generations = source.generations(from, kPage);
  if (!generations) return tl::unexpected(generations.error());
  view.generations = rows_in(*generations, "generations");
  return view;
}

// Brings a view up to date; of the generations only the new ones are asked for.
Status look_again(Source& source, View& view) {
  auto run = source.run();
  if (!run) return tl::unexpected(run.error());
  view.run = std::move(*run);
  // A resumed run may have fallen back behind what was seen.
  if (view.generations.size() > count_in(view.run, "committed")) view.generations = json::array();
  auto fresh = source.all_generations(static_cast<std::uint32_t>(view.generations.size()));
  if (!fresh) return tl::unexpected(fresh.error());
  for (json& one : (*fresh)["generations"]) view.generations.push_back(std::move(one));
  auto workers = source.workers();
  if (!workers) return tl::unexpected(workers.error());
  view.workers = rows_in(*workers, "workers");
  auto events = source.events(0, kWatchedEvents);
  if (!events) return tl::unexpected(events.error());
  view.events = rows_in(*events, "events");
  return {};
}

bool over(const json& run) {
  const std::string state = text_in(run, "state");
  return state != "running" && state != "paused";
}

void put(std::string& out, const char* label, const std::string& text) {
  std::string line = label;
  line.resize(12, ' ');
  out += line + text + "\n";
}

std::string trials_line(const json& run) {
  std::string text = with_commas(count_in(run, "trials")) + " in " + duration(number_in(run, "seconds"));
  const double rate = number_in(run, "trials_per_second");
  if (rate > 0 && rate < 1e15) text += ", " + with_commas(static_cast<std::uint64_t>(rate)) + " a second";
  const double left = number_in(run, "seconds_left");
  if (std::isfinite(left) && !over(run)) text += ", " + duration(left) + " left";
  return text;
}

// What more slots would bring, when the run has shown it.
std::string hint_text(const json& workers) {
  const std::uint64_t wanted = count_in(workers, "slots_wanted"), slots = count_in(workers, "slots");
  return wanted > slots ? "; it could use " + with_commas(wanted - slots) + " more slots" : "";
}

std::string status_text(const View& view) {
  const json& run = view.run;
  const json &fitness = part_in(run, "fitness"), &workers = part_in(run, "workers"),
             &species = part_in(run, "species");
  std::string out = text_in(run, "name") + ": " + text_in(run, "state") + ", " +
                    std::to_string(count_in(run, "committed")) + " of " +
                    std::to_string(count_in(run, "generations")) + " generations (" + text_in(run, "phase") +
                    ")\n";
  std::vector<double> best;
  for (const json& g : view.generations) best.push_back(number_in(g, "best"));
  if (!best.empty())
    put(out, "fitness",
        "best " + fixed(number_in(fitness, "best")) + "  mean " + fixed(number_in(fitness, "mean")) +
            "  best ever " + fixed(number_in(fitness, "best_ever")) + "  " + sparkline(best, kSparkWidth));
  if (!best.empty())
    put(out, "species",
        std::to_string(count_in(species, "count")) + " at threshold " +
            fixed(number_in(species, "threshold"), 2));
  put(out, "trials", trials_line(run));
  const json& evaluations = part_in(run, "evaluations");
  if (!over(run) && count_in(evaluations, "total") > 0)
    put(out, "now",
        std::to_string(count_in(evaluations, "done")) + " of " +
            std::to_string(count_in(evaluations, "total")) + " evaluations of generation " +
            std::to_string(count_in(run, "generation")));
  if (!over(run))
    put(out, "workers",
        std::to_string(count_in(workers, "active")) + " with " + std::to_string(count_in(workers, "slots")) +
            (count_in(workers, "slots") == 1 ? " slot, " : " slots, ") +
            std::to_string(count_in(workers, "busy")) + " busy" + hint_text(workers));
  const json& champion = part_in(run, "champion");
  put(out, "champion",
      flag_in(champion, "chosen")      ? "chosen on fresh placements"
      : flag_in(champion, "available") ? "not chosen yet; the best so far can be had"
                                       : "none yet");
  put(out, "folder", text_in(run, "folder"));
  if (!text_in(run, "error").empty()) put(out, "error", text_in(run, "error"));
  if (text_in(run, "state") == "interrupted")
    put(out, "next", "its server is gone; go on with: evograsp train --resume " + text_in(run, "folder"));
  return out;
}

int status(Source& source, const StatusOptions& options) {
  const auto view = look_once(source);
  if (!view) return report(view.error());
  if (options.source.json) {
    print_json(view->run);
  } else {
    print(status_text(*view));
  }
  return kExitOk;
}

// ---- watch ----

// As much of it as the terminal holds: the plot gets what the rest leaves.
std::string screen(const View& view, TerminalSize size) {
  FitnessPlot plot;
  for (const json& g : view.generations)
    plot.points.push_back({static_cast<std::uint32_t>(count_in(g, "generation")), number_in(g, "best"),
                           number_in(g, "mean"), static_cast<std::uint32_t>(count_in(g, "species"))});
  Table workers({{"worker"},
                 {"state"},
                 {"slots", Align::kRight},
                 {"busy", Align::kRight},
                 {"trials/s", Align::kRight}});
  for (const json& w : view.workers) {
    if (text_in(w, "state") == "gone") continue;
    workers.add({text_in(w, "identity"), text_in(w, "state"), std::to_string(count_in(w, "slots")),
                 std::to_string(count_in(w, "busy")), fixed(number_in(w, "trials_per_second"), 0)});
  }
  const std::string top = status_text(view) + "\n";
  std::string rest;
  if (!workers.empty()) rest += "\n" + workers.text();
  if (!view.events.empty()) rest += "\n";
  for (const json& e : view.events) rest += text_in(e, "kind") + ": " + text_in(e, "text") + "\n";
  constexpr int kAroundPlot = 4, kLeastRows = 5,
                kMostRows = 13;  // title, axis and its numbers, the last line
  const auto others = static_cast<int>(std::ranges::count(top + rest, '\n')) + kAroundPlot;
  const int rows = std::clamp(size.rows - others, kLeastRows, kMostRows);
  --size.rows;  // a newline at the very end would scroll
  return fit(top + to_text(plot, plot_columns(size.columns), rows) + rest, size) + "\n";
}

// Home, every line cleared behind itself, then the rest of the screen: no flicker.
void redraw(const std::string& text) {
  std::string out = "\033[H";
  for (const char c : text) out += c == '\n' ? std::string("\033[K\n") : std::string(1, c);
  print(out + "\033[J");
  std::fflush(stdout);
}

std::string plain_line(const json& run) {
  const json& fitness = part_in(run, "fitness");
  return text_in(run, "state") + "  generation " + std::to_string(count_in(run, "committed")) + "/" +
         std::to_string(count_in(run, "generations")) + "  best " + fixed(number_in(fitness, "best"), 3) +
         "  mean " + fixed(number_in(fitness, "mean"), 3) + "  species " +
         std::to_string(count_in(part_in(run, "species"), "count")) + "  " +
         with_commas(count_in(run, "trials")) + " trials\n";
}

class Watcher {
 public:
  explicit Watcher(const WatchOptions& options)
      : json_(options.source.json), terminal_(!json_ && progress_style(stdout) == ProgressStyle::kBar) {}

  void show(const View& view) {
    if (terminal_) {
      if (last_.is_null()) print("\033[2J");
      redraw(screen(view, terminal_size(stdout)));
    } else if (json_) {
      print_json_line(view.run);
    } else if (changed(view.run)) {
      print(plain_line(view.run));
      std::fflush(stdout);
    }
    last_ = view.run;
    silent_ = false;
  }

  void silence(const Error& error) {
    if (!silent_) warn(error.message + "; trying again");
    silent_ = true;
  }

 private:
  bool changed(const json& run) const {
    const auto differs = [&](const char* key) { return part_in(last_, key) != part_in(run, key); };
    return last_.is_null() || differs("state") || differs("committed") || differs("phase");
  }
  const bool json_, terminal_;
  json last_;
  bool silent_ = false;
};

int watch(Source& source, const WatchOptions& options) {
  Watcher watcher(options);
  View view;
  bool ever = false;
  for (std::uint64_t shown = 1;; ++shown) {
    const Status looked = look_again(source, view);
    // A server may be restarted under a watcher's eyes; one that was never there is an error.
    if (!looked && !(ever && looked.error().code == ErrorCode::kUnavailable)) return report(looked.error());
    if (looked) {
      watcher.show(view);
      if (over(view.run) || std::ferror(stdout) != 0) return kExitOk;
      ever = true;
    } else {
      watcher.silence(looked.error());
    }
    if (shown == options.count) return kExitOk;
    std::this_thread::sleep_for(std::chrono::duration<double>(options.interval));
  }
}

}  // namespace

void add_status(CLI::App& app, Outcome& outcome) {
  const auto options = std::make_shared<StatusOptions>();
  CLI::App* sub = app.add_subcommand("status", "how a run stands");
  add_source_options(*sub, options->source);
  sub->footer(
      "Examples:\n  evograsp status\n  evograsp status --run runs/quick\n"
      "  evograsp status --server http://master:8080 --json | jq .fitness.best");
  answer_with_source(*sub, options, outcome, status);

  const auto watched = std::make_shared<WatchOptions>();
  sub = app.add_subcommand("watch", "follow a run until it ends: fitness, workers, events");
  add_source_options(*sub, watched->source);
  sub->add_option("--interval", watched->interval, "seconds between two looks")
      ->check(CLI::Range(0.05, 3600.0))
      ->capture_default_str();
  sub->add_option("--count", watched->count, "stop after so many looks (0: at the end of the run)")
      ->capture_default_str();
  sub->footer(
      "On a terminal a screen that redraws itself; elsewhere a line a generation; with --json a document a "
      "look.\n\n"
      "Examples:\n  evograsp watch\n  evograsp watch --run runs/quick --interval 0.5");
  answer_with_source(*sub, watched, outcome, watch);
}

}  // namespace evograsp::cli

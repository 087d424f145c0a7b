// report.html: one page that tells a run, with everything it shows inside.
#include <cstdio>

#include "cli/page.h"
#include "cli/progress.h"
#include "cli/run_folder.h"
#include "common/config.h"

namespace evograsp::cli {
namespace {

std::string fixed(double value, int digits) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
  return buffer;
}

std::string row(const std::string& name, const std::string& value) {
  return "<tr><td>" + name + "</td><td>" + html_escaped(value) + "</td></tr>\n";
}

std::string summary(const RunFolder& run) {
  std::string out = "<table class=\"facts\">\n" + row("state", run.state) +
                    row("seed", std::to_string(run.info.config.run().seed()));
  std::string objects;
  for (const std::string& object : run.info.config.scene().object())
    objects += (objects.empty() ? "" : ", ") + object;
  out += row("objects", objects) + row("hand", run.info.config.grasp().hand());
  if (!run.generations.empty()) {
    const server::GenerationRecord& last = run.generations.back();
    out += row("generations", std::to_string(run.generations.size())) +
           row("simulated grasps", with_commas(last.trials));
    out += row("time", duration(last.seconds));
  }
  if (run.champion) {
    const proto::Champion& champion = *run.champion;
    out += row("champion", "bred in generation " + std::to_string(champion.generation()) + ", fitness " +
                               fixed(champion.fitness(), 3));
    if (champion.validation_trials() > 0) {
      out += row("grasps on fresh placements", std::to_string(champion.validation_successes()) + " of " +
                                                   std::to_string(champion.validation_trials()));
    }
  }
  return out + "</table>\n";
}

// At most about 25 generations, evenly spaced, the last one always.
std::string table(const RunFolder& run) {
  std::string out =
      "<table>\n<tr><th>generation</th><th>best</th><th>mean</th><th>deviation</th><th>species</th>"
      "<th>links</th><th>grasps so far</th></tr>\n";
  const std::size_t step = std::max<std::size_t>(1, run.generations.size() / 25);
  for (std::size_t i = 0; i < run.generations.size(); ++i) {
    if (i % step != 0 && i + 1 != run.generations.size()) continue;
    const server::GenerationRecord& g = run.generations[i];
    out += "<tr><td>" + std::to_string(g.generation) + "</td><td>" + fixed(g.best, 3) + "</td><td>" +
           fixed(g.mean, 3) + "</td><td>" + fixed(g.deviation, 3) + "</td><td>" + std::to_string(g.species) +
           "</td><td>" + fixed(g.links, 1) + "</td><td>" + with_commas(g.trials) + "</td></tr>\n";
  }
  return out + "</table>\n";
}

std::string config_text(const proto::Config& config) {
  std::string out;
  for (const auto& [key, value] : flatten(config)) out += key + " = " + value + "\n";
  return html_escaped(out);
}

}  // namespace

Result<std::string> report_html(const RunFolder& run, const std::filesystem::path& picture) {
  const auto svg = to_svg(figure_of(run.plot()));
  if (!svg) return svg;
  std::string out = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                    html_escaped(run.info.name) + " - evograsp</title>\n<style>" + kPageStyle +
                    "</style></head><body>\n";
  out += "<h1>" + html_escaped(run.info.name) + "</h1>\n" + summary(run);
  out += "<h2>Fitness</h2>\n" + *svg + "\n";
  if (const auto png = read_file(picture, 16 << 20)) {
    out +=
        "<h2>A grasp of the champion</h2>\n<img alt=\"the champion's grasp\" src=\"data:image/png;base64," +
        base64(*png) + "\">\n";
  }
  out += "<h2>Generations</h2>\n" + table(run);
  out += "<h2>Every setting</h2>\n<pre>" + config_text(run.info.config) + "</pre>\n</body></html>\n";
  return out;
}

}  // namespace evograsp::cli

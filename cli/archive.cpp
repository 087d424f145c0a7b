// `evograsp archive`: the kinds of grasp that a run has found.
#include <algorithm>
#include <cmath>

#include "cli/heat_map.h"
#include "cli/inputs.h"
#include "cli/output.h"
#include "cli/queries.h"
#include "cli/table.h"

namespace evograsp::cli {
namespace {

using nlohmann::json;

struct ArchiveOptions {
  SourceOptions source;
  std::uint32_t best = 5;
  std::string out;
};

HeatAxis axis_of(const json& document, const char* name) {
  constexpr std::uint64_t kMostBins = 64;
  const json& axis = document.at(name);
  HeatAxis result;
  result.label = text_in(axis, "words") + ", " + text_in(axis, "unit");
  result.low = number_in(axis, "low");
  result.high = number_in(axis, "high");
  result.bins = static_cast<int>(std::clamp<std::uint64_t>(count_in(axis, "bins"), 1, kMostBins));
  return result;
}

HeatMap map_of(const json& document) {
  HeatMap map;
  map.x = axis_of(document, "x");
  map.y = axis_of(document, "y");
  map.title = "Kinds of grasp";
  map.value_label = "fitness of the best of each kind";
  map.value.assign(static_cast<std::size_t>(map.x.bins) * static_cast<std::size_t>(map.y.bins), std::nan(""));
  for (const json& elite : document.at("elites")) {
    const std::uint64_t x = count_in(elite, "x"), y = count_in(elite, "y");
    if (x < static_cast<std::uint64_t>(map.x.bins) && y < static_cast<std::uint64_t>(map.y.bins))
      map.value[x + y * static_cast<std::uint64_t>(map.x.bins)] = number_in(elite, "fitness");
  }
  return map;
}

std::vector<json> by_fitness(const json& document) {
  std::vector<json> elites(document.at("elites").begin(), document.at("elites").end());
  const auto rank = [](const json& elite) {
    const double fitness = number_in(elite, "fitness");
    return std::isfinite(fitness) ? fitness : -HUGE_VAL;
  };
  std::stable_sort(elites.begin(), elites.end(),
                   [&](const json& a, const json& b) { return rank(a) > rank(b); });
  return elites;
}

std::string cell_name(const json& elite) {
  return std::to_string(count_in(elite, "x")) + "," + std::to_string(count_in(elite, "y"));
}

std::string table_of(const json& document, const std::vector<json>& elites, std::size_t most) {
  const auto value = [](const json& axis, double v) {
    return fixed(v, text_in(axis, "unit") == "m" ? 3 : 1);
  };
  const json &x = document.at("x"), &y = document.at("y");
  const auto head = [](const json& axis) {
    std::string name = text_in(axis, "measure");
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    return name + ", " + text_in(axis, "unit");
  };
  Table table({{"cell"},
               {"fitness", Align::kRight},
               {"judged", Align::kRight},
               {head(x), Align::kRight},
               {head(y), Align::kRight},
               {"generation", Align::kRight}});
  for (std::size_t i = 0; i < elites.size() && i < most; ++i) {
    const json& e = elites[i];
    table.add({cell_name(e), fixed(number_in(e, "fitness")), std::to_string(count_in(e, "judged")),
               value(x, number_in(e, "x_value")), value(y, number_in(e, "y_value")),
               std::to_string(count_in(e, "generation"))});
  }
  return table.text();
}

// An answer that is no map must not be taken for one.
bool is_map(const json& document) {
  return document.contains("x") && document["x"].is_object() && document.contains("y") &&
         document["y"].is_object() && document.contains("elites") && document["elites"].is_array();
}

Status draw(const HeatMap& map, const std::string& file) {
  if (!file.ends_with(".svg")) return write_png(map, file);
  const auto svg = to_svg(map);
  if (!svg) return tl::unexpected(svg.error());
  return write_file(file, *svg + "\n");
}

int archive(Source& source, const ArchiveOptions& options) {
  const auto document = source.archive();
  if (!document) return report(document.error());
  if (!is_map(*document))
    return report(Error{ErrorCode::kInvalid, source.name() + ": no map of grasps came"});
  const HeatMap map = map_of(*document);
  if (!options.out.empty()) {
    if (const Status drawn = draw(map, options.out); !drawn) return report(drawn.error());
    if (!options.source.json) return say(options.out + ": the map as a picture"), kExitOk;
  }
  if (options.source.json) return print_json(*document), kExitOk;
  const std::vector<json> elites = by_fitness(*document);
  if (elites.empty()) return say("no grasp is on the map yet"), kExitOk;
  std::string out = std::to_string(elites.size()) + " of " + std::to_string(count_in(*document, "cells")) +
                    " kinds of grasp found; the fitness of the best of each kind:\n\n" + to_text(map) + "\n";
  const std::size_t most = options.best == 0 ? elites.size() : options.best;
  out += table_of(*document, elites, most);
  out += "\nFetch one: evograsp champion --cell " + cell_name(elites.front()) + " --out grasp.pb\n";
  print(out);
  return kExitOk;
}

}  // namespace

void add_archive(CLI::App& app, Outcome& outcome) {
  const auto options = std::make_shared<ArchiveOptions>();
  CLI::App* sub = app.add_subcommand("archive", "the kinds of grasp a run has found, and the best of each");
  add_source_options(*sub, options->source);
  sub->add_option("--best", options->best, "list so many of the fittest kinds (0: all)")
      ->capture_default_str();
  sub->add_option("-o,--out", options->out, "draw the map into this file (.png or .svg)")
      ->type_name("FILE")
      ->check([](const std::string& file) {
        const bool known = file.ends_with(".png") || file.ends_with(".svg");
        return known ? std::string() : "'" + file + "' ends neither in .png nor in .svg";
      });
  sub->footer(
      "For runs with neat.archive (docs/NEAT.md).\n"
      "Examples:\n  evograsp train mug --set neat.archive={} --out runs/kinds\n"
      "  evograsp archive --run runs/kinds\n  evograsp archive --run runs/kinds --out map.png\n"
      "  evograsp champion --run runs/kinds --cell 8,3 --out from_above.pb");
  answer_with_source(*sub, options, outcome, archive);
}

}  // namespace evograsp::cli

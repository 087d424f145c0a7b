// `evograsp epsilon FILE`: the quality of wrench sets from a file.
#include <memory>

#include "cli/cli.h"
#include "cli/output.h"
#include "cli/report.h"
#include "cli/table.h"
#include "cli/wrench_file.h"

namespace evograsp::cli {
namespace {

struct Options {
  std::string file;
  bool hull = false;
  bool json = false;
};

struct Answer {
  WrenchSet set;  // without its wrenches
  double epsilon = 0;
  sim::WrenchHull hull;  // --hull
};

Result<Answer> answer(WrenchSet set, const Options& options, sim::Epsilon& epsilon) {
  Answer out;
  out.epsilon = epsilon(set.wrenches);
  const std::string where = options.file + ":" + std::to_string(set.line) + ": ";
  if (epsilon.gave_up()) {
    return fail(ErrorCode::kInvalid, where + "the set is too large to answer: its hull has too many facets");
  }
  if (options.hull) {
    auto hull = sim::wrench_hull(set.wrenches);
    if (!hull) return fail(hull.error().code, where + hull.error().message);
    out.hull = *hull;
  }
  set.wrenches.clear();
  out.set = std::move(set);
  return out;
}

Result<std::vector<Answer>> answers(const Options& options) {
  auto reader = WrenchReader::open(options.file);
  if (!reader) return tl::unexpected(reader.error());
  sim::Epsilon epsilon;
  std::vector<Answer> all;
  while (true) {
    auto set = reader->next();
    if (!set) return tl::unexpected(set.error());
    if (!*set) return all;
    auto one = answer(std::move(**set), options, epsilon);
    if (!one) return tl::unexpected(one.error());
    all.push_back(std::move(*one));
  }
}

nlohmann::ordered_json as_json(const Answer& a, bool with_hull) {
  nlohmann::ordered_json out{{"object", a.set.object}, {"id", a.set.id}, {"epsilon", a.epsilon}};
  if (with_hull) {
    out.update(
        {{"force_closure", a.hull.force_closure}, {"volume", a.hull.volume}, {"weakest", a.hull.weakest}});
  }
  return out;
}

void print_table(const std::vector<Answer>& all, bool with_hull) {
  std::vector<Table::Column> columns = {{"object"}, {"id"}, {"epsilon", Align::kRight}};
  if (with_hull) columns.push_back({"volume", Align::kRight});
  Table table(columns);
  for (const Answer& a : all) {
    table.add({a.set.object, a.set.id, fixed(a.epsilon, 9), with_hull ? fixed(a.hull.volume, 9) : ""});
  }
  print(table.text());
}

int run(const Options& options) {
  const auto all = answers(options);
  if (!all) return report(all.error());
  if (options.json) {
    auto document = nlohmann::ordered_json::array();
    for (const Answer& a : *all) document.push_back(as_json(a, options.hull));
    print_json(document);
  } else {
    print_table(*all, options.hull);
  }
  return kExitOk;
}

}  // namespace

void add_epsilon(CLI::App& app, Outcome& outcome) {
  auto options = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("epsilon", "the grasp quality of wrench sets in a file");
  sub->add_option("file", options->file, "wrench sets as text, plain or gzip; - for standard input")
      ->required();
  sub->add_flag("--hull", options->hull, "also the volume of the hull and its weakest direction (slow)");
  sub->add_flag("--json", options->json, "machine-readable: an array, one entry a set");
  sub->footer(
      "Epsilon is the radius of the largest ball about the origin inside the convex hull of a set's "
      "wrenches; 0\n"
      "without force closure. A file holds sets, each a header and its wrenches, a line each:\n"
      "  set OBJECT ID wrenches N\n"
      "  fx fy fz tx ty tz\n\n"
      "Examples:\n"
      "  evograsp epsilon grasps.txt.gz\n"
      "  evograsp epsilon grasps.txt --json --hull");
  sub->callback([options, &outcome] { outcome.exit_code = run(*options); });
}

}  // namespace evograsp::cli

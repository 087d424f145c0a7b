#include "cli/study/study.h"

#include <algorithm>

#include "cli/study/check.h"
#include "common/near_miss.h"
#include "embedded/experiments.h"

namespace evograsp::cli::study {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".txtpb";
constexpr std::size_t kMostRuns = 100000;

std::string stem(std::string_view name) {
  return std::string(name.substr(0, name.size() - kExtension.size()));
}

std::optional<std::string_view> builtin(std::string_view name) {
  for (const embedded::File& file : embedded::experiments())
    if (stem(file.name) == name) return file.data;
  return std::nullopt;
}

// The values of an axis; those of slots_to_cores made.
std::vector<proto::StudyValue> values_of(const proto::StudyAxis& axis, int cores) {
  if (!axis.slots_to_cores()) return {axis.value().begin(), axis.value().end()};
  std::vector<proto::StudyValue> values;
  for (int slots = 1;; slots = std::min(2 * slots, cores)) {
    proto::StudyValue& value = values.emplace_back();
    value.set_name(std::to_string(slots));
    value.set_slots(static_cast<std::uint32_t>(slots));
    if (slots >= cores) return values;
  }
}

struct Axis {
  std::string name;
  std::vector<proto::StudyValue> values;
};

std::vector<std::string> names(const std::vector<proto::StudyValue>& values) {
  std::vector<std::string> out;
  for (const proto::StudyValue& value : values) out.push_back(value.name());
  return out;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(separator, from), text.size());
    parts.push_back(text.substr(from, end - from));
    from = end + 1;
  }
  return parts;
}

// Leaves the values that --only names.
Status restrict_to(std::vector<Axis>& axes, const std::string& only) {
  const std::size_t equals = only.find('=');
  const std::string name = only.substr(0, equals);
  std::vector<std::string> known;
  for (const Axis& axis : axes) known.push_back(axis.name);
  const auto axis = std::ranges::find(axes, name, &Axis::name);
  if (equals == std::string::npos || axis == axes.end()) {
    return fail(ErrorCode::kUsage, "--only " + only + ": AXIS=VALUE,... is wanted; axes are " +
                                       join_words(known) + did_you_mean(name, known));
  }
  std::vector<proto::StudyValue> kept;
  for (const std::string& wanted : split(only.substr(equals + 1), ',')) {
    const auto value = std::ranges::find_if(axis->values, [&](const auto& v) { return v.name() == wanted; });
    if (value == axis->values.end()) {
      return fail(ErrorCode::kUsage, "--only " + only + ": " + name + " is one of " +
                                         join_words(names(axis->values)) +
                                         did_you_mean(wanted, names(axis->values)));
    }
    kept.push_back(*value);
  }
  axis->values = std::move(kept);
  return {};
}

void add(PlannedRun& run, const proto::StudyAxis& axis, const proto::StudyValue& value) {
  run.place[axis.name()] = value.name();
  for (const proto::StudyTag& tag : value.tag()) run.place[tag.name()] = tag.value();
  run.id += value.name() + "-";
  if (value.has_config()) run.config = value.config();
  run.overrides.insert(run.overrides.end(), value.set().begin(), value.set().end());
  if (value.has_slots()) run.slots = static_cast<int>(value.slots());
  run.test_objects.insert(run.test_objects.end(), value.test_object().begin(), value.test_object().end());
}

// "nobox_{class}" with the name of the run's value on the axis `class`.
std::string filled_in(std::string config, const std::map<std::string, std::string>& place) {
  for (const auto& [axis, value] : place) {
    const std::string gap = "{" + axis + "}";
    for (std::size_t at = config.find(gap); at != std::string::npos; at = config.find(gap, at + value.size()))
      config.replace(at, gap.size(), value);
  }
  return config;
}

}  // namespace

std::vector<std::string> builtin_studies() {
  std::vector<std::string> found;
  for (const embedded::File& file : embedded::experiments()) found.push_back(stem(file.name));
  std::ranges::sort(found);
  return found;
}

tl::expected<LoadedStudy, Diagnostics> load_study(const std::string& name_or_file) {
  LoadedStudy loaded;
  std::error_code error;
  std::string text;
  if (const auto inside = builtin(name_or_file); inside && !fs::is_regular_file(name_or_file, error)) {
    loaded.name = name_or_file;
    loaded.file = name_or_file + " (built in)";
    text = *inside;
  } else {
    auto data = read_file(name_or_file);
    if (!data) {
      std::string message = data.error().message.substr(name_or_file.size() + 2);
      if (data.error().code == ErrorCode::kNotFound)
        message += "; studies are " + join_words(builtin_studies(), 20) +
                   did_you_mean(name_or_file, builtin_studies());
      return tl::unexpected(Diagnostics{{name_or_file, 0, 0, message}});
    }
    loaded.name = fs::path(name_or_file).stem().string();
    loaded.file = name_or_file;
    loaded.base = fs::path(name_or_file).parent_path();
    text = std::move(*data);
  }
  Positions positions;
  Diagnostics mistakes = parse_text(text, loaded.file, loaded.study, &positions);
  if (mistakes.empty()) mistakes = check(loaded.study, loaded.file, positions);
  if (!mistakes.empty()) return tl::unexpected(mistakes);
  return loaded;
}

Result<std::vector<PlannedRun>> plan(const LoadedStudy& study, const Selection& selection) {
  std::vector<Axis> axes;
  for (const proto::StudyAxis& axis : study.study.axis())
    axes.push_back({axis.name(), values_of(axis, selection.cores)});
  for (const std::string& only : selection.only)
    if (auto status = restrict_to(axes, only); !status) return tl::unexpected(status.error());

  const std::uint64_t seeds = selection.seeds > 0 ? selection.seeds : study.study.seeds();
  std::size_t choices = 1;
  for (const Axis& axis : axes) choices *= std::min(axis.values.size(), kMostRuns + 1);
  if (choices > kMostRuns || choices * seeds > kMostRuns) {
    return fail(ErrorCode::kInvalid, study.file + ": more than " + std::to_string(kMostRuns) + " runs");
  }
  std::vector<PlannedRun> runs;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    for (std::size_t choice = 0; choice < choices; ++choice) {
      PlannedRun& run = runs.emplace_back();
      run.seed = seed;
      run.config = study.study.config();
      run.overrides.assign(study.study.set().begin(), study.study.set().end());
      std::size_t rest = choice, block = choices;  // the first axis changes slowest
      for (std::size_t a = 0; a < axes.size(); ++a) {
        block /= axes[a].values.size();
        add(run, study.study.axis(static_cast<int>(a)), axes[a].values[rest / block]);
        rest %= block;
      }
      run.config = filled_in(run.config, run.place);
      run.id += std::to_string(seed);
      run.overrides.insert(run.overrides.end(), selection.overrides.begin(), selection.overrides.end());
      run.overrides.push_back("run.seed=" + std::to_string(seed));
    }
  }
  return runs;
}

const std::vector<std::string>& columns_of(proto::StudySource source) {
  static const std::vector<std::string> kRuns = {
      "slots", "generations", "trials", "seconds", "best", "best_by",
      // Of the first generation whose best reached the study's `reach`, in training or on fresh placements.
      "reached", "reached_generation", "reached_trials", "reached_seconds", "fresh_reached_generation",
      "fresh_reached_trials", "fresh_reached_seconds",
      // Means over the bests of the last tenth of the generations.
      "end_best", "end_f1", "end_f2", "end_f3", "end_f4", "end_fresh_fitness", "end_fresh_success",
      "champion_generation", "champion_fitness", "validation_trials", "validation_success",
      "validation_fitness"};
  static const std::vector<std::string> kTests = {"object",       "n",      "successes", "success", "lifts",
                                                  "lift_success", "unseen", "extent_m",  "refused"};
  static const std::vector<std::string> kGenerations = {
      "generation", "trials", "seconds", "best", "best_so_far", "mean",          "species",      "links",
      "f1",         "f2",     "f3",      "f4",   "fresh_n",     "fresh_success", "fresh_fitness"};
  return source == proto::RUNS ? kRuns : source == proto::TESTS ? kTests : kGenerations;
}

std::vector<std::string> place_columns(const proto::Study& study) {
  std::vector<std::string> columns;
  for (const proto::StudyAxis& axis : study.axis()) columns.push_back(axis.name());
  for (const proto::StudyAxis& axis : study.axis()) {
    for (const proto::StudyValue& value : axis.value()) {
      for (const proto::StudyTag& tag : value.tag())
        if (std::ranges::find(columns, tag.name()) == columns.end()) columns.push_back(tag.name());
    }
  }
  return columns;
}

std::string label_of(const proto::Study& study, const std::string& axis, const std::string& value) {
  for (const proto::StudyAxis& a : study.axis()) {
    if (a.name() != axis) continue;
    for (const proto::StudyValue& v : a.value())
      if (v.name() == value && v.has_label()) return v.label();
  }
  return value;
}

}  // namespace evograsp::cli::study

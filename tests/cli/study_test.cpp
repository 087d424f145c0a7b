// Studies: their files, their matrix, and how data is summed up.
#include "cli/study/study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "cli/inputs.h"
#include "cli/study/dataset.h"
#include "cli/study/results.h"

namespace evograsp::cli::study {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kTwoAxes[] = R"(
title: "two axes"
config: "quick"
set: "neat.population=20"
seeds: 3
axis {
  name: "class"
  value { name: "cube" set: "scene.object=cube" test_object: "cube_5cm" tag { name: "shape" value: "edged" } }
  value { name: "sphere" config: "sphere" tag { name: "shape" value: "round" } }
}
axis {
  name: "box"
  value { name: "true" label: "with" }
  value { name: "false" set: "trials.bounding_box=false" slots: 1 }
}
)";

class StudyFile {
 public:
  explicit StudyFile(const std::string& text)
      : path_(fs::temp_directory_path() / ("evograsp_study_" + std::to_string(::getpid()) + ".txtpb")) {
    std::ofstream(path_) << text;
  }
  ~StudyFile() { fs::remove(path_); }
  std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

LoadedStudy two_axes() {
  return load_study(StudyFile(kTwoAxes).path()).value();
}

std::string mistakes_in(const std::string& text) {
  const auto loaded = load_study(StudyFile(text).path());
  return loaded ? "" : evograsp::text(loaded.error());
}

TEST(StudyPlan, IsEveryChoiceTimesTheSeedsWithSeedsOutermost) {
  const auto runs = plan(two_axes(), {}).value();
  std::vector<std::string> ids;
  for (const PlannedRun& run : runs) ids.push_back(run.id);
  EXPECT_THAT(ids, ElementsAre("cube-true-1", "cube-false-1", "sphere-true-1", "sphere-false-1",
                               "cube-true-2", "cube-false-2", "sphere-true-2", "sphere-false-2",
                               "cube-true-3", "cube-false-3", "sphere-true-3", "sphere-false-3"));
  const PlannedRun& run = runs[5];
  EXPECT_EQ(run.config, "quick");
  EXPECT_EQ(runs[6].config, "sphere");
  EXPECT_THAT(run.overrides, ElementsAre("neat.population=20", "scene.object=cube",
                                         "trials.bounding_box=false", "run.seed=2"));
  EXPECT_EQ(run.slots, 1);
  EXPECT_THAT(run.test_objects, ElementsAre("cube_5cm"));
  EXPECT_EQ(run.place.at("box"), "false");
  EXPECT_EQ(run.place.at("shape"), "edged");
}

TEST(StudyPlan, FollowsTheCommand) {
  Selection selection;
  selection.seeds = 1;
  selection.only = {"box=false", "class=sphere"};
  selection.overrides = {"run.generations=2"};
  const auto runs = plan(two_axes(), selection).value();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].id, "sphere-false-1");
  EXPECT_THAT(runs[0].overrides, Contains("run.generations=2"));
  EXPECT_EQ(runs[0].overrides.back(), "run.seed=1") << "no other setting decides the seed";

  selection.only = {"bax=false"};
  EXPECT_THAT(plan(two_axes(), selection).error().message, HasSubstr("did you mean 'box'"));
  selection.only = {"class=cubes"};
  EXPECT_THAT(plan(two_axes(), selection).error().message, HasSubstr("did you mean 'cube'"));
}

TEST(StudyPlan, ConfigsAreChosenByTheNamesOfValues) {
  const std::string axes = R"(title: "s" seeds: 1
axis { name: "class" value { name: "cube" } value { name: "mug" } }
axis { name: "box" value { name: "true" config: "{class}" } value { name: "false" config: "nobox_{class}" } })";
  std::vector<std::string> configs;
  const auto planned = plan(load_study(StudyFile(axes).path()).value(), {});
  ASSERT_TRUE(planned);
  for (const PlannedRun& run : *planned) configs.push_back(run.config);
  EXPECT_THAT(configs, ElementsAre("cube", "nobox_cube", "mug", "nobox_mug"));
  EXPECT_THAT(mistakes_in("title: 's' config: '{clas}' axis { name: 'class' value { name: 'cube' } }"),
              HasSubstr("there is no axis 'clas'; allowed are class: did you mean 'class'?"));
}

TEST(StudyPlan, SlotsGoUpToTheCores) {
  const StudyFile file("title: 's' config: 'quick' seeds: 1 axis { name: 'slots' slots_to_cores: true }");
  Selection selection;
  selection.cores = 6;
  std::vector<int> slots;
  const auto planned = plan(load_study(file.path()).value(), selection);
  ASSERT_TRUE(planned);
  for (const PlannedRun& run : *planned) slots.push_back(run.slots);
  EXPECT_THAT(slots, ElementsAre(1, 2, 4, 6));
}

TEST(StudyFiles, MistakesAreNamedWithTheirPlace) {
  EXPECT_THAT(mistakes_in("seeds: 2"), HasSubstr("title"));
  EXPECT_THAT(mistakes_in("title: 'x'"), HasSubstr("no config"));
  EXPECT_THAT(mistakes_in("title: 'x' config: 'quick'\ntable { name: 't' by: 'objet' }"),
              HasSubstr(":2:23: 'table[0].by[0]': there is no column 'objet'"));
  EXPECT_THAT(mistakes_in("title: 'x' config: 'quick' plot { name: 'p' y: 'bests' }"),
              HasSubstr("did you mean 'best'"));
  EXPECT_THAT(mistakes_in("title: 'x' config: 'quick' plot { name: '../p' y: 'best' }"),
              HasSubstr("a word of"));
  EXPECT_THAT(mistakes_in("title: 'x' config: 'quick' table { name: 'runs' by: 'seed' }"),
              HasSubstr("is written already"));
  EXPECT_THAT(mistakes_in("title: 'x' config: 'quick' axis { name: 'best' value { name: 'a' } }"),
              HasSubstr("is a column already"));
  EXPECT_THAT(mistakes_in(std::string(kTwoAxes) +
                          "table { name: 't' by: 'class' reference { at: 'cubes' value: 1 } }"),
              HasSubstr("did you mean 'cube'"));
  EXPECT_THAT(mistakes_in("title: 'x' sheeds: 3"), HasSubstr("unknown key"));
  EXPECT_THAT(evograsp::text(load_study("liftt").error()), HasSubstr("did you mean 'lift'"));
}

// Every study that ships can be planned, its configs load, and what it draws and sums up has names.
TEST(BuiltinStudies, AreWhole) {
  ASSERT_GE(builtin_studies().size(), 9u);
  for (const std::string& name : builtin_studies()) {
    const auto loaded = load_study(name);
    ASSERT_TRUE(loaded.has_value()) << name << ": " << evograsp::text(loaded.error());
    const auto runs = plan(*loaded, {});
    ASSERT_TRUE(runs.has_value()) << name;
    std::set<std::string> ids;
    for (const PlannedRun& run : *runs) {
      EXPECT_TRUE(ids.insert(run.id).second) << name << ": two runs in one folder: " << run.id;
      if (run.seed > 1) continue;
      const auto config = load_config(run.config, run.overrides, known_names());
      EXPECT_TRUE(config.has_value()) << name << ", " << run.id << ": " << evograsp::text(config.error());
    }
    EXPECT_GT(loaded->study.plot_size() + loaded->study.table_size(), 0) << name;
  }
}

TEST(Sums, AreThoseOfTheTextbook) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_EQ(quantile({0, 1, 2, 3, 4}, 0.25), 1);
  EXPECT_DOUBLE_EQ(quantile({1, 2, 4, 8}, 0.25), 1.75);
  EXPECT_EQ(median({1, std::nan(""), 3}), 2);
  EXPECT_TRUE(std::isnan(median({})));
  EXPECT_EQ(mean({1, 2, 6}), 3);
}

// Binomial(n, 1/2): with 6 values the range misses the median with 2/64 = 3.1 %; leaving the ends out needs 9
// (2 (1 + 9) / 512 = 3.9 %), and 12 for the next (2 (1 + 12 + 66) / 4096 = 3.9 %).
TEST(Sums, TheMediansIntervalIsThatOfOrderStatistics) {
  const auto interval = [](int n) {
    std::vector<double> values;
    for (int i = n; i >= 1; --i) values.push_back(i);
    return median_interval(values);
  };
  for (const int n : {1, 2, 5, 6, 8}) {
    EXPECT_EQ(interval(n).low, 1) << n;
    EXPECT_EQ(interval(n).high, n) << n;
  }
  EXPECT_EQ(interval(9).low, 2);
  EXPECT_EQ(interval(9).high, 8);
  EXPECT_EQ(interval(12).low, 3);
  EXPECT_EQ(interval(12).high, 10);
}

TEST(Cells, KeepTheirTypesInJsonAndTheirTextInCsv) {
  DataTable table;
  table.columns = {"object", "box", "slots", "success", "note"};
  table.rows = {{cell_of("cube"), cell_of("true"), cell_of("4"), 0.1 + 0.2, Cell()},
                {cell_of("a,\"b\""), cell_of("false"), cell_of("0.5"), 1, "line\nbreak"}};
  EXPECT_EQ(to_json(table).dump(),
            R"([{"object":"cube","box":true,"slots":4,"success":0.30000000000000004,"note":null},)"
            R"({"object":"a,\"b\"","box":false,"slots":0.5,"success":1,"note":"line\nbreak"}])");
  EXPECT_EQ(to_csv(table),
            "object,box,slots,success,note\ncube,true,4,0.3,\n\"a,\"\"b\"\"\",false,0.5,1,\"line\nbreak\"\n");
}

// Two seeds of one class: the table's row is their median, and the reference stands beside it.
TEST(SummedTables, AreMediansOverSeedsBesideTheReference) {
  StudyFile file(std::string(kTwoAxes) + R"(
test {}
table {
  name: "t" by: "object" by: "box" mean_row: true
  column { of: "success" }
  column { of: "success" summary: LOWEST name: "lowest" }
  column { of: "n" }
  reference { at: "cube" at: "true" value: 0.76 }
})");
  const LoadedStudy study = load_study(file.path()).value();
  std::vector<DoneRun> done;
  for (const auto& [seed, grasped] : {std::pair{1u, 60}, {2u, 90}, {3u, 80}}) {
    DoneRun run;
    run.plan = plan(study, {}).value()[0];
    run.plan.seed = seed;
    run.measured.tests = {{"cube", 100, grasped, 50, 0, true, 0.06, ""},
                          {"mug", 100, 10, 0, 0, true, 0.08, ""}};
    done.push_back(run);
  }
  const Data data = collect(study.study, done);
  EXPECT_EQ(data.tests.rows.size(), 6u);
  EXPECT_EQ(data.tests.at(0, "lift_success"), 0.5);
  const SummedTable summed = sum_up(study.study.table(0), data);
  EXPECT_EQ(to_json(summed.data).dump(),
            R"([{"object":"cube","box":true,"success":0.8,"lowest":0.6,"n":100,"seeds":3,"thesis":0.76},)"
            R"({"object":"mug","box":true,"success":0.1,"lowest":0.1,"n":100,"seeds":3,"thesis":null}])");
  ASSERT_EQ(summed.means.size(), 1u);
  EXPECT_EQ(summed.means[0][0], "mean");
  EXPECT_DOUBLE_EQ(summed.means[0][2].get<double>(), 0.45);
}

}  // namespace
}  // namespace evograsp::cli::study

// Config files: what is accepted, and what is said about what is not.
#include "common/config.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "proto/hand.pb.h"
#include "proto/object.pb.h"

namespace evograsp {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::vector<std::string> complaints(const std::string& source) {
  proto::Config config;
  std::vector<std::string> out;
  for (const Diagnostic& d : parse_text(source, "f", config)) out.push_back(d.text());
  return out;
}

std::string only_complaint(const std::string& source) {
  const auto all = complaints(source);
  EXPECT_THAT(all, SizeIs(1)) << source;
  return all.empty() ? "" : all.front();
}

// A config file in a folder of its own; the folder goes with it.
class File {
 public:
  explicit File(const std::string& content) {
    folder_ = fs::temp_directory_path() / ("evograsp_config_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    std::ofstream(path()) << content;
  }
  ~File() { fs::remove_all(folder_); }
  std::string path() const { return (folder_ / "c.txtpb").string(); }
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

std::string load_error(const std::string& file, const std::vector<std::string>& overrides = {},
                       const KnownNames& names = {}) {
  const auto loaded = load_config(file, overrides, names);
  EXPECT_FALSE(loaded.has_value());
  return loaded ? "" : text(loaded.error());
}

TEST(ParseText, ReadsEveryKindOfValue) {
  proto::Config config;
  const auto mistakes = parse_text(R"(# comment
    run { name: "a" 'b' seed: 18446744073709551615 stop_at_fitness: .5 }
    neat: < population: 0x10, recurrent: true; hidden_choice: [SINE, ABS] hidden_choice: RELU >
    scene { object: ["x", 'y'] friction [{a: "p" b: "q" mu: 1e-1}, {mu: 2}] }
    camera { eye { x: -1.5f z: 2 } }
  )",
                                   "f", config);
  ASSERT_THAT(mistakes, IsEmpty()) << text(mistakes);
  EXPECT_EQ(config.run().name(), "ab");
  EXPECT_EQ(config.run().seed(), 18446744073709551615ULL);
  EXPECT_EQ(config.run().stop_at_fitness(), 0.5);
  EXPECT_EQ(config.neat().population(), 16u);
  EXPECT_TRUE(config.neat().recurrent());
  EXPECT_THAT(config.neat().hidden_choice(), ElementsAre(proto::SINE, proto::ABS, proto::RELU));
  EXPECT_THAT(config.scene().object(), ElementsAre("x", "y"));
  EXPECT_EQ(config.scene().friction_size(), 2);
  EXPECT_EQ(config.scene().friction(0).mu(), 0.1);
  EXPECT_EQ(config.camera().eye().x(), -1.5);
}

TEST(ParseText, NamesANearMiss) {
  EXPECT_EQ(only_complaint("neat {\n  populaton: 20\n}"),
            "f:2:3: unknown key 'populaton' in neat: did you mean 'population'?");
  EXPECT_EQ(only_complaint("naet { }"), "f:1:1: unknown key 'naet' at the top level: did you mean 'neat'?");
}

TEST(ParseText, SendsAKeyToItsSection) {
  EXPECT_EQ(only_complaint("population: 20"),
            "f:1:1: unknown key 'population' at the top level: it belongs into neat { }");
}

TEST(ParseText, ListsWhatIsAllowedWhenNothingIsNear) {
  EXPECT_THAT(only_complaint("store { qqqqqqqq { a: [1, {}] } }"),
              HasSubstr("allowed are keep_generations, journal_seconds, journal_trials"));
}

TEST(ParseText, ChecksRangesWhereTheValueStands) {
  EXPECT_EQ(only_complaint("neat { population: 1 }"),
            "f:1:20: 'neat.population' is 1, allowed is from 2 to 1e+06");
  EXPECT_EQ(only_complaint("neat { survival: 0 }"),
            "f:1:18: 'neat.survival' is 0, allowed is above 0 and at most 1");
  EXPECT_EQ(only_complaint("scene { clearance: -0.1 }"),
            "f:1:20: 'scene.clearance' is -0.1, allowed is at least 0 m");
  EXPECT_EQ(only_complaint("run { generations: -3 }"),
            "f:1:20: 'run.generations' is -3, negative numbers are not allowed");
  EXPECT_EQ(only_complaint("run { generations: 4294967296 }"),
            "f:1:20: 'run.generations' is 4294967296, allowed is at most 4294967295");
  EXPECT_EQ(only_complaint("neat { max_weight: 1e999 }"),
            "f:1:20: 'neat.max_weight' is too large a number: at most 1e9 is allowed");
  EXPECT_EQ(only_complaint("scene { clearance: 1e10 }"),
            "f:1:20: 'scene.clearance' is too large a number: at most 1e9 is allowed");
  EXPECT_EQ(only_complaint("fitness { lambda: -1e308 }"),
            "f:1:19: 'fitness.lambda' is too large a number: at most 1e9 is allowed");
}

TEST(ParseText, SaysWhatATypeTakes) {
  EXPECT_EQ(only_complaint("neat { population: \"many\" }"),
            "f:1:20: 'neat.population' takes a whole number, found \"many\"");
  EXPECT_EQ(only_complaint("neat { population: 1.5 }"),
            "f:1:20: 'neat.population' takes a whole number, found 1.5");
  EXPECT_EQ(only_complaint("neat { survival: nan }"), "f:1:18: 'neat.survival' takes a number, found nan");
  EXPECT_EQ(only_complaint("neat { recurrent: maybe }"),
            "f:1:19: 'neat.recurrent' takes true or false, found maybe");
  EXPECT_EQ(only_complaint("run { name: cube }"), "f:1:13: 'run.name' takes text in quotes, found cube");
  EXPECT_EQ(only_complaint("neat: 5"), "f:1:7: 'neat' takes '{', found 5");
  EXPECT_EQ(only_complaint("run { seed: [1, 2] }"), "f:1:13: 'run.seed' takes one value, not a list");
  EXPECT_EQ(only_complaint("neat { topology: DIRCT }"),
            "f:1:18: 'neat.topology' is DIRCT, allowed are HIDDEN_LAYER, DIRECT, SPARSE, UNCONNECTED, "
            "FEATURES: did "
            "you mean 'DIRECT'?");
}

TEST(ParseText, RefusesASecondValueForOneKey) {
  EXPECT_EQ(only_complaint("run {\n seed: 1\n seed: 2\n}"), "f:3:2: 'run.seed' was already given on line 2");
  EXPECT_EQ(only_complaint("run { }\nrun { seed: 3 }"), "f:2:1: 'run' was already given on line 1");
}

TEST(ParseText, RefusesTwoOfOneChoice) {
  proto::ObjectFile object;
  const auto mistakes = parse_text("sphere { radius: 0.1 }\nmug { }", "f", object);
  ASSERT_THAT(mistakes, SizeIs(1));
  EXPECT_EQ(mistakes[0].text(), "f:2:1: 'mug' and 'sphere' exclude each other: give one shape");
}

TEST(ParseText, MissesRequiredKeys) {
  proto::HandFile hand;
  const auto mistakes = parse_text("urdf: \"h.urdf\"", "f", hand);
  ASSERT_THAT(mistakes, SizeIs(1));
  EXPECT_EQ(mistakes[0].text(), "f: 'palm_link' is missing: it has no default");
}

TEST(ParseText, ReportsEverythingAtOnce) {
  const auto all =
      complaints("neat {\n populaton: 1\n survival: 7\n c1_excess: x\n}\nrun { seed 4 }\nfoo: {a: [1]}\n");
  EXPECT_THAT(all, ElementsAre(HasSubstr("f:2:2: unknown key"), HasSubstr("f:3:12: 'neat.survival' is 7"),
                               HasSubstr("f:4:13: 'neat.c1_excess' takes a number"),
                               HasSubstr("f:6:12: expected ':' after 'seed', found 4"),
                               HasSubstr("f:7:1: unknown key 'foo'")));
}

TEST(ParseText, FindsWhereABraceWasForgotten) {
  EXPECT_EQ(only_complaint("run { seed: 1 }\nneat {\n population: 9\n"),
            "f:2:6: 'neat' is opened here and never closed");
  EXPECT_EQ(only_complaint("run { }\n}"), "f:2:1: expected a key at the top level, found }");
  EXPECT_THAT(complaints("scene { object: [\"a\" "),
              ElementsAre("f:1:17: the list 'scene.object' is opened here and never closed",
                          "f:1:7: 'scene' is opened here and never closed"));
}

TEST(ParseText, IsBounded) {
  EXPECT_THAT(only_complaint(std::string((1 << 20) + 1, '\n')), HasSubstr("larger than 1 MiB"));
  std::string deep;
  for (int i = 0; i < 20000; ++i) deep += "a{";
  EXPECT_THAT(complaints(deep), SizeIs(1));
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "x: 1\n";
  EXPECT_THAT(complaints(many), SizeIs(31));
  EXPECT_THAT(complaints(many).back(), HasSubstr("too many mistakes"));
}

TEST(ParseText, RefusesTextThatIsNotUtf8) {
  EXPECT_EQ(only_complaint("run { name: \"\\377\" }"), "f:1:13: 'run.name' is not UTF-8 text");
  EXPECT_EQ(only_complaint("run { name: \"a\\000b\" }"), "f:1:13: 'run.name' is not UTF-8 text");
  EXPECT_THAT(complaints("run { name: \"gr\xc3\xbc\xc3\x9f\" }"), IsEmpty());
}

TEST(ParseText, SaysOnceThatAFileIsNoText) {
  EXPECT_EQ(only_complaint(std::string("run {\xff\x01\x02 }\n\0\0", 13)),
            "f: not a text file: byte 5 is no UTF-8 text");
  EXPECT_THAT(complaints("| a | b |\n| c |"), SizeIs(2)) << "one complaint a line";
}

TEST(LoadConfig, WritesEveryDefaultAndSaysWhereValuesCameFrom) {
  const File file("neat { population: 50 }\nscene { object: 'cube' }\ncamera { eye { x: 0.4 } }\n");
  ::setenv("EVOGRASP_NEAT__SURVIVAL", "0.5", 1);
  ::setenv("EVOGRASP_RUN__SEED", "7", 1);
  const auto loaded = load_config(file.path(), {"run.seed=9", "scene.object=mug,sphere"});
  ::unsetenv("EVOGRASP_NEAT__SURVIVAL");
  ::unsetenv("EVOGRASP_RUN__SEED");
  ASSERT_TRUE(loaded.has_value()) << text(loaded.error());
  const proto::Config& config = loaded->config;
  EXPECT_EQ(config.neat().population(), 50u);
  EXPECT_EQ(config.neat().survival(), 0.5);
  EXPECT_EQ(config.run().seed(), 9u) << "a flag beats the environment";
  EXPECT_EQ(config.run().name(), "c");
  EXPECT_THAT(config.scene().object(), ElementsAre("mug", "sphere"));
  EXPECT_TRUE(config.net().has_listen());
  EXPECT_EQ(config.camera().eye().x(), 0.4);
  EXPECT_EQ(config.camera().eye().z(), 0.55) << "a component left out keeps its default";
  EXPECT_EQ(config.grasp().workspace_centre().z(), 0.125);
  EXPECT_FALSE(config.has_neat() && config.neat().has_hyperneat());
  EXPECT_FALSE(config.camera().has_noise());
  EXPECT_FALSE(config.fitness().has_gamma()) << "the preset decides it";

  EXPECT_EQ(loaded->origin.at("neat.population"), Origin::kFile);
  EXPECT_EQ(loaded->origin.at("neat.survival"), Origin::kEnvironment);
  EXPECT_EQ(loaded->origin.at("run.seed"), Origin::kFlag);
  EXPECT_EQ(loaded->origin.at("scene.object[1]"), Origin::kFlag);
  EXPECT_EQ(loaded->origin.at("camera.eye.x"), Origin::kFile);
  EXPECT_EQ(loaded->origin.at("camera.eye.z"), Origin::kDefault);
  EXPECT_EQ(loaded->origin.size(), flatten(config).size());
}

// A run's config is kept as text with every default, and read again when the run goes on.
TEST(ParseText, WhatWasWrittenWithItsDefaultsIsReadAgain) {
  proto::Config config;
  write_defaults(config);
  std::string written;
  ASSERT_TRUE(google::protobuf::TextFormat::PrintToString(config, &written));
  for (const std::string& complaint : complaints(written))
    EXPECT_THAT(complaint, HasSubstr("missing")) << "what the file must say has no default";
}

TEST(LoadConfig, NamesTheFlagThatIsWrong) {
  const File file("scene { object: 'cube' }");
  EXPECT_EQ(load_error(file.path(), {"neat.populaton=5"}),
            "--set neat.populaton: unknown key 'populaton' in neat: did you mean 'population'?");
  EXPECT_EQ(load_error(file.path(), {"neat.population=x"}),
            "--set neat.population: 'neat.population' takes a whole number, found x");
  EXPECT_EQ(load_error(file.path(), {"neat.population"}),
            "--set neat.population: expected KEY=VALUE, e.g. neat.population=200");
  EXPECT_EQ(load_error(file.path(), {"neat.population=5 survival: 0.1"}),
            "--set neat.population: expected one value, found '5 survival: 0.1'");
  EXPECT_THAT(load_error(file.path(), {"scene.friction.mu=1"}), HasSubstr("a list is replaced as a whole"));
}

TEST(LoadConfig, NamesTheVariableThatIsWrong) {
  const File file("scene { object: 'cube' }");
  ::setenv("EVOGRASP_NEAT__POPULATION", "1", 1);
  const std::string error = load_error(file.path());
  ::unsetenv("EVOGRASP_NEAT__POPULATION");
  EXPECT_EQ(error,
            "environment EVOGRASP_NEAT__POPULATION: 'neat.population' is 1, allowed is from 2 to 1e+06");
}

TEST(LoadConfig, ChecksThatNamedFilesExist) {
  const File file("scene {\n object: 'cube'\n object: 'cupe'\n object: 'shapes/x.obj' }\n");
  const KnownNames names{{"scene.object", {"cube", "sphere"}}};
  const std::string error = load_error(file.path(), {}, names);
  EXPECT_THAT(error, HasSubstr("c.txtpb:3:10: 'scene.object[1]': no file and nothing built in is named "
                               "'cupe': did you mean 'cube'?"));
  EXPECT_THAT(
      error,
      HasSubstr("c.txtpb:4:10: 'scene.object[2]': no such file: 'shapes/x.obj'; built in are cube, sphere"));
  fs::create_directories(file.folder() / "shapes");
  std::ofstream(file.folder() / "shapes/x.obj") << "v 0 0 0\n";
  EXPECT_TRUE(
      load_config(file.path(), {"scene.object=cube," + (file.folder() / "shapes/x.obj").string()}, names)
          .has_value());
}

TEST(LoadConfig, ARunsNameIsOneFolder) {
  for (const char* name : {"../../escaped", "/tmp/escaped", "..", ".", "a\\nb", ""})
    EXPECT_THAT(load_error(File("run { name: \"" + std::string(name) + "\" }").path()),
                HasSubstr("'run.name': is no name for a folder"))
        << name;
}

TEST(LoadConfig, FindsContradictions) {
  const File file(
      "scene { object: 'cube' objects_in_scene: 2 }\ncamera { near: 2 far: 1 object_frame: true }\nfitness { "
      "terms: '23' }\n");
  const std::string error = load_error(file.path());
  EXPECT_THAT(error, HasSubstr("c.txtpb:1:42: 'scene.objects_in_scene': is more than the 1 objects listed"));
  EXPECT_THAT(error, HasSubstr("c.txtpb:2:23: 'camera.far': must lie beyond camera.near"));
  EXPECT_THAT(error, HasSubstr("'camera.object_frame': needs AXIS among camera.feature"));
  EXPECT_THAT(error, HasSubstr("'fitness.terms': is \"23\", allowed are 1, 12, 13, 14, 123, 124, 134, 1234"));
}

TEST(LoadConfig, BoundsTheTrialsOfValidation) {
  EXPECT_THAT(
      load_error(File("champion { candidates: 50 validation_trials: 400000000 }").path()),
      HasSubstr("'champion.validation_trials': champion.candidates x validation_trials are 20000000000"));
}

TEST(LoadConfig, ASubstrateFollowsTheCameraAndMayNotDiffer) {
  const File file("scene { object: 'cube' }\nneat { hyperneat { } }\ncamera { columns: 40 rows: 30 }\n");
  const auto loaded = load_config(file.path());
  ASSERT_TRUE(loaded.has_value()) << text(loaded.error());
  EXPECT_EQ(loaded->config.neat().hyperneat().input_columns(), 40u);
  EXPECT_EQ(loaded->config.neat().hyperneat().input_rows(), 30u);
  const auto smaller = load_config(file.path(), {"camera.rows=8"});
  ASSERT_TRUE(smaller.has_value()) << text(smaller.error());
  EXPECT_EQ(smaller->config.neat().hyperneat().input_rows(), 8u) << "flags count as well";

  const File wrong(
      "scene { object: 'cube' }\nneat { recurrent: true\nhyperneat {\ninput_columns: 30\noutputs: 6 } }\n");
  const std::string error = load_error(wrong.path());
  EXPECT_THAT(error,
              HasSubstr("c.txtpb:4:16: 'neat.hyperneat.input_columns': is 30, but camera.columns is 20"));
  EXPECT_THAT(error, HasSubstr("c.txtpb:5:10: 'neat.hyperneat.outputs': is 6, but a pose"));
  EXPECT_THAT(error, HasSubstr("c.txtpb:2:19: 'neat.recurrent': substrates are feed-forward"));
}

TEST(LoadConfig, AsksForAnObject) {
  const File file("");
  EXPECT_THAT(load_error(file.path()), HasSubstr("name at least one object"));
}

TEST(LoadConfig, KnowsBuiltInConfigs) {
  const auto loaded = load_config("quick");
  ASSERT_TRUE(loaded.has_value()) << text(loaded.error());
  EXPECT_EQ(loaded->config.run().name(), "quick");
  EXPECT_THAT(load_error("quik"), HasSubstr("did you mean 'quick'?"));
}

TEST(LoadConfig, EveryShippedConfigLoads) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(EVOGRASP_SOURCE_DIR) / "configs")) {
    if (entry.path().extension() != ".txtpb") continue;
    const auto loaded = load_config(entry.path().string());
    EXPECT_TRUE(loaded.has_value()) << text(loaded.error());
    ++count;
  }
  EXPECT_EQ(count, static_cast<int>(builtin_configs().size()));
}

TEST(ReadFile, SaysWhyNot) {
  const File file("hello");
  EXPECT_EQ(read_file(file.path()).value(), "hello");
  EXPECT_THAT(read_file(file.folder() / "d.txtpb").error().message,
              EndsWith("no such file: did you mean 'c.txtpb'?"));
  EXPECT_THAT(read_file(file.folder()).error().message, EndsWith("is a folder, not a file"));
  EXPECT_THAT(read_file(file.path(), 3).error().message, HasSubstr("larger than 3 bytes"));
}

}  // namespace
}  // namespace evograsp

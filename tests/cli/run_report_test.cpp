// report.html and the folder of a run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "cli/inputs.h"
#include "cli/run_folder.h"

namespace evograsp::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("evograsp_cli_test_" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  const fs::path& path() const { return path_; }
  void put(const std::string& name, const std::string& content) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << content;
  }

 private:
  fs::path path_;
};

RunFolder example() {
  RunFolder run;
  run.info.name = "a <b> & \"c\"";
  run.info.config.mutable_scene()->add_object("mug");
  run.info.config.mutable_neat();
  run.state = "finished";
  for (std::uint32_t g = 0; g < 100; ++g) {
    server::GenerationRecord record;
    record.generation = g;
    record.best = g / 100.0;
    record.trials = (g + 1) * 600;
    record.seconds = g;
    run.generations.push_back(record);
  }
  run.champion.emplace();
  run.champion->set_validation_trials(40);
  run.champion->set_validation_successes(39);
  return run;
}

TEST(RunReport, TellsTheRunAndNeedsNothingElse) {
  const Folder folder;
  folder.put("grasp.png", "\x89PNG picture");
  const std::string html = report_html(example(), folder.path() / "grasp.png").value();
  EXPECT_THAT(html, HasSubstr("<h1>a &lt;b&gt; &amp; &quot;c&quot;</h1>"));
  EXPECT_THAT(html, HasSubstr("<td>39 of 40</td>"));
  EXPECT_THAT(html, HasSubstr("<td>60,000</td>"));
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,iVBORyBwaWN0dXJl"));
  EXPECT_THAT(html, HasSubstr("neat.population = 120")) << "defaults are part of what was run";
  for (const char* elsewhere : {"src=\"http", "href=\"http", "<script", "@import"})
    EXPECT_THAT(html, Not(HasSubstr(elsewhere)));
}

TEST(RunReport, DoesWithoutPictureChampionAndGenerations) {
  RunFolder empty;
  empty.info.name = "empty";
  EXPECT_THAT(report_html(empty, "/nonexistent.png").value(), Not(HasSubstr("<img")));
}

TEST(FreshFolder, IsTheFirstWithoutARun) {
  const Folder folder;
  const fs::path wanted = folder.path() / "quick";
  EXPECT_EQ(fresh_folder(wanted), wanted);
  folder.put("quick/run.db", "");
  folder.put("quick-2/run.db", "");
  EXPECT_EQ(fresh_folder(wanted), folder.path() / "quick-3");
}

TEST(WriteFile, ReplacesAsAWholeAndLeavesNothingBehind) {
  const Folder folder;
  folder.put("f", "old");
  ASSERT_TRUE(write_file(folder.path() / "f", "new").has_value());
  EXPECT_EQ(read_file(folder.path() / "f").value(), "new");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
  EXPECT_EQ(write_file("/nonexistent/f", "x").error().code, ErrorCode::kIo);
}

TEST(ReadChampion, RefusesWhatIsNone) {
  const Folder folder;
  folder.put("noise.pb", "\x08\xff\xff not a champion");
  folder.put("empty.pb", "");
  for (const char* name : {"noise.pb", "empty.pb"}) {
    const auto champion = read_champion(folder.path() / name);
    ASSERT_FALSE(champion.has_value()) << name;
    EXPECT_THAT(champion.error().message, HasSubstr("is not a champion"));
  }
  EXPECT_EQ(read_champion(folder.path()).error().code, ErrorCode::kNotFound)
      << "a folder without champion.pb";
}

TEST(ObjectsIn, FindsMeshesAndObjectFilesInOrder) {
  const Folder folder;
  for (const char* name : {"b.OBJ", "a.txtpb", "c.stl", "readme.md", "d.png"}) folder.put(name, "x");
  const auto found = objects_in(folder.path()).value();
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(fs::path(found[0]).filename(), "a.txtpb");
  EXPECT_EQ(fs::path(found[1]).filename(), "b.OBJ");
  EXPECT_EQ(objects_in("/nonexistent").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace evograsp::cli

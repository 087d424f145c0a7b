#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "cli/wrench_file.h"
#include "tests/data_folder.h"

namespace evograsp::cli {
namespace {

namespace fs = std::filesystem;

class EpsilonCommandTest : public ::testing::Test {
 protected:
  EpsilonCommandTest()
      : folder_(fs::temp_directory_path() / ("evograsp_epsilon_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~EpsilonCommandTest() override { fs::remove_all(folder_); }

  std::string write(const std::string& text, bool gzip = false) {
    const std::string path = folder_ / (gzip ? "sets.txt.gz" : "sets.txt");
    if (gzip) {
      gzFile file = gzopen(path.c_str(), "wb");
      gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
      gzclose(file);
    } else {
      std::ofstream(path) << text;
    }
    return path;
  }

  // The command's exit code, and what it printed on stdout and stderr.
  struct Said {
    int code;
    std::string out, error;
  };
  static Said call(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"evograsp", "epsilon"};
    for (const std::string& a : arguments) argv.push_back(a.c_str());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = run(static_cast<int>(argv.size()), argv.data());
    std::string out = ::testing::internal::GetCapturedStdout();
    return {code, out, ::testing::internal::GetCapturedStderr()};
  }

  fs::path folder_;
};

// A cross-polytope of radius 6: epsilon 6 / sqrt(6) = sqrt(6).
std::string cross(const std::string& name) {
  std::string text = "set " + name + " 7 contacts 3 wrenches 12 epsilon 2.449489742783178\n";
  for (int axis = 0; axis < 6; ++axis) {
    for (const char* value : {"6", "-6.0e0"}) {
      for (int x = 0; x < 6; ++x) text += std::string(x == axis ? value : "0") + (x < 5 ? " " : "\n");
    }
  }
  return text;
}

TEST_F(EpsilonCommandTest, PrintsOneValueASetFromPlainTextAndGzip) {
  const std::string text = "# two sets\n\n" + cross("a") + "\n" + cross("b");
  for (const bool gzip : {false, true}) {
    const Said said = call({write(text, gzip), "--json"});
    ASSERT_EQ(said.code, 0) << said.error;
    const auto json = nlohmann::json::parse(said.out);
    ASSERT_EQ(json.size(), 2u);
    EXPECT_EQ(json[1]["object"], "b");
    EXPECT_EQ(json[1]["id"], "7");
    EXPECT_NEAR(json[1]["epsilon"].get<double>(), 2.449489742783178, 1e-12);
  }
  const Said table = call({write(text)});
  EXPECT_NE(table.out.find("2.449489743"), std::string::npos) << table.out;
}

TEST_F(EpsilonCommandTest, HullAddsVolumeAndWeakestDirection) {
  const Said said = call({write(cross("a")), "--json", "--hull"});
  ASSERT_EQ(said.code, 0) << said.error;
  const auto json = nlohmann::json::parse(said.out);
  EXPECT_TRUE(json[0]["force_closure"].get<bool>());
  EXPECT_NEAR(json[0]["volume"].get<double>(), 64.0 / 720 * 46656, 1e-6) << "2^6 r^6 / 6!";
  EXPECT_EQ(json[0]["weakest"].size(), 6u);
}

TEST_F(EpsilonCommandTest, SaysWhereAndWhatIsWrong) {
  struct Case {
    std::string text, said;
  };
  const Case cases[] = {
      {"wrong 1 2\n", ":1: 'set OBJECT ID wrenches N' expected, found 'wrong'"},
      {"set a 1 contacts 3\n", ":1: the header does not say how many wrenches follow"},
      {"set a 1 wrenches\n", ":1: a set's header is"},
      {"set a 1 wrenches -4\n", ":1: 'wrenches' must be a whole number from 0 to 4096"},
      {"set a 1 wrenches 99999999999\n", ":1: 'wrenches' must be"},
      {"\nset a 1 wrenches 2\n1 2 3 4 5 6\n", ":3: the file ends after 1 of 2 wrenches"},
      {"set a 1 wrenches 1\n1 2 3 4 5\n", ":2: a wrench is six numbers (fx fy fz tx ty tz), found 5 words"},
      {"set a 1 wrenches 1\n1 2 x 4 5 6\n", ":2: 'x' is not a finite number"},
      {"set a 1 wrenches 1\n1 2 nan 4 5 6\n", ":2: 'nan' is not a finite number"},
      {"set a 1 wrenches 1\n1 2 1e999 4 5 6\n", ":2: '1e999' is not a finite number"},
      {std::string(5000, 'x'), ":1: a line of more than 1024 bytes"},
  };
  for (const Case& c : cases) {
    const Said said = call({write(c.text)});
    EXPECT_EQ(said.code, static_cast<int>(ErrorCode::kInvalid)) << c.text;
    EXPECT_NE(said.error.find(c.said), std::string::npos) << said.error;
    EXPECT_EQ(said.out, "");
  }
  EXPECT_EQ(call({folder_ / "nothing.txt"}).code, static_cast<int>(ErrorCode::kNotFound));
  EXPECT_EQ(call({folder_}).code, static_cast<int>(ErrorCode::kInvalid));
  EXPECT_EQ(call({write("")}).code, 0) << "no sets, no values";
}

TEST_F(EpsilonCommandTest, ATruncatedGzipFileIsAnErrorNotAShortAnswer) {
  const std::string path = write(cross("a") + cross("b"), true);
  fs::resize_file(path, fs::file_size(path) / 2);
  const Said said = call({path});
  EXPECT_NE(said.code, 0);
  EXPECT_NE(said.error.find("sets.txt.gz"), std::string::npos) << said.error;
}

// Half a gigabyte of nothing in half a megabyte would be read for a minute.
TEST_F(EpsilonCommandTest, AFileOfBlankLinesPackedSmallIsRefused) {
  const Said said = call({write(std::string(40u << 20, '\n'), true)});
  EXPECT_EQ(said.code, 3) << said.error;
  EXPECT_NE(said.error.find("packed more than"), std::string::npos) << said.error;
  // The same set over and over packs well, too: as much of it as fits a page of a report is no attack.
  std::string sets;
  for (int i = 0; i < 200; ++i) sets += cross("a");
  EXPECT_EQ(call({write(sets, true)}).code, 0);
}

// Grasps measured in another simulator, each with its exact epsilon.
TEST(OracleTest, EveryMeasuredGraspHasItsEpsilon) {
  const fs::path root = testing::data_folder();
  if (root.empty()) return;
  int sets = 0, closed = 0;
  for (const auto& entry : fs::directory_iterator(root / "oracle/wrenches")) {
    if (entry.path().extension() != ".gz") continue;
    auto reader = WrenchReader::open(entry.path());
    ASSERT_TRUE(reader) << reader.error().message;
    sim::Epsilon epsilon;
    for (auto set = reader->next(); !set || *set; set = reader->next()) {
      ASSERT_TRUE(set) << set.error().message;
      ASSERT_TRUE((*set)->epsilon) << "line " << (*set)->line;
      ASSERT_NEAR(epsilon((*set)->wrenches), *(*set)->epsilon, 1e-9) << "line " << (*set)->line;
      ++sets;
      closed += *(*set)->epsilon > 0 ? 1 : 0;
    }
    EXPECT_GT(closed, 0) << entry.path();
  }
  EXPECT_GE(sets, 539);
  std::printf("%d measured grasps, %d force-closed\n", sets, closed);
}

}  // namespace
}  // namespace evograsp::cli

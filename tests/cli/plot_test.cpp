// Plots and progress: what a person sees while and after a run.
#include "cli/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "cli/output.h"
#include "cli/progress.h"

namespace evograsp::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

FitnessPlot rising() {
  FitnessPlot plot{"rising", {}};
  for (std::uint32_t g = 0; g < 40; ++g) plot.points.push_back({g, g / 39.0, g / 78.0, 5});
  return plot;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

TEST(AxisEnd, IsOneOrTheNextRoundNumber) {
  EXPECT_EQ(axis_end(0), 1);
  EXPECT_EQ(axis_end(0.97), 1);
  EXPECT_EQ(axis_end(1), 1);
  EXPECT_EQ(axis_end(1.1), 2);
  EXPECT_EQ(axis_end(21), 25);
  EXPECT_EQ(axis_end(4200), 5000);
  EXPECT_EQ(axis_end(9001), 10000);
}

TEST(TextPlot, RisesFromTheLowerLeftToTheUpperRight) {
  const auto rows = lines(to_text(rising(), 20, 5));
  ASSERT_EQ(rows.size(), 8u);  // a title, 5 rows, the axis and its numbers
  EXPECT_THAT(rows[1], StartsWith("       1 ┤               "));
  EXPECT_THAT(rows[5], StartsWith("       0 ┤⣀"));
  EXPECT_THAT(rows[7], HasSubstr("generation"));
  EXPECT_THAT(rows[7], ::testing::EndsWith("39"));
}

TEST(TextPlot, TakesNoPointsOnePointAndStrangeOnes) {
  EXPECT_EQ(to_text({"none", {}}), "(no generation yet)\n");
  EXPECT_THAT(to_text({"one", {{0, 0.5, 0.2, 1}}}), HasSubstr("┤"));
  EXPECT_THAT(to_text({"odd", {{0, -3, -5, 1}, {1, 1e300, -1e300, 1}}}), HasSubstr("generation"));
}

TEST(SvgPlot, IsOneElementWithoutReferencesToElsewhere) {
  const auto svg = to_svg(figure_of(rising()));
  ASSERT_TRUE(svg.has_value());
  EXPECT_THAT(*svg, StartsWith("<svg"));
  EXPECT_THAT(*svg, Not(HasSubstr("href=\"http")));
}

// A curve that began at the words drawn before it would show a line across the picture.
TEST(SvgPlot, CurvesBeginAtTheFirstGeneration) {
  const std::string svg = to_svg(figure_of(rising())).value();
  std::vector<std::string> starts;
  for (std::size_t at = svg.find("stroke-width:2.2"); at != std::string::npos;
       at = svg.find("stroke-width:2.2", at + 1)) {
    const std::size_t points = svg.find(" d=\"M ", at);
    ASSERT_NE(points, std::string::npos);
    starts.push_back(svg.substr(points + 6, svg.find(' ', points + 6) - points - 6));
  }
  ASSERT_EQ(starts.size(), 2u);
  EXPECT_EQ(starts[0], starts[1]);
  EXPECT_LT(std::stod(starts[0]), 90) << "the left end of the axis";
}

TEST(PngPlot, WritesAPictureOrSaysWhyNot) {
  const auto file = std::filesystem::temp_directory_path() / "evograsp_plot_test.png";
  ASSERT_TRUE(write_png(figure_of(rising()), file).has_value());
  std::string head(8, '\0');
  std::ifstream(file, std::ios::binary).read(head.data(), 8);
  EXPECT_EQ(head, "\x89PNG\r\n\x1a\n");
  std::filesystem::remove(file);
  const auto status = write_png(figure_of(rising()), "/nonexistent/folder/f.png");
  ASSERT_FALSE(status.has_value());
  EXPECT_THAT(status.error().message, StartsWith("/nonexistent/folder/f.png: "));
}

TEST(Terminal, TextIsCutByCharactersNotBytes) {
  EXPECT_EQ(cut("a│⣀b", 3), "a│⣀");
  EXPECT_EQ(cut("a│⣀b", 4), "a│⣀b");
  EXPECT_EQ(cut("abc", 0), "");
  EXPECT_EQ(fit("one\ntwo\nthree\n", {2, 2}), "on\ntw");
  EXPECT_EQ(plot_columns(80), 64);
  EXPECT_EQ(plot_columns(60), 48);
  EXPECT_EQ(plot_columns(1), 20);
}

TEST(Progress, SaysEverythingInOneLine) {
  server::GenerationReport report;
  report.generation = 36;
  report.best = 0.91234;
  report.mean = 0.5;
  report.species = 9;
  EXPECT_EQ(Progress::line(report, 100, 5210.7, 75, 0),
            "generation 37/100  best 0.912  mean 0.500  species 9  5,210 trials/s  1:15 min left");
  EXPECT_EQ(Progress::line(report, 100, 5210.7, 75, 0, false),
            "generation 37/100  best 0.912  species 9  5,210 trials/s  1:15 min left");
  EXPECT_THAT(Progress::line(report, 37, 1, 0, 4), HasSubstr(" ████ "));
}

TEST(Duration, ReadsLikeAClock) {
  EXPECT_EQ(duration(0.44), "0.4 s");
  EXPECT_EQ(duration(9.96), "10 s");
  EXPECT_EQ(duration(59.4), "59 s");
  EXPECT_EQ(duration(59.6), "1:00 min");
  EXPECT_EQ(duration(3 * 3600 + 5 * 60), "3:05 h");
  EXPECT_EQ(duration(-5), "0.0 s");
}

TEST(WithCommas, GroupsThousands) {
  EXPECT_EQ(with_commas(0), "0");
  EXPECT_EQ(with_commas(999), "999");
  EXPECT_EQ(with_commas(6000000), "6,000,000");
}

}  // namespace
}  // namespace evograsp::cli

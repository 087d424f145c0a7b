// Figures: scales, and what the drawing holds.
#include "cli/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cli/chart_draw.h"
#include "cli/chart_scale.h"

namespace evograsp::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> labels(const Scale& scale) {
  std::vector<std::string> out;
  for (const Tick& tick : scale.ticks) out.push_back(tick.label);
  return out;
}

TEST(Scale, HasRoundNumbers) {
  EXPECT_THAT(labels(vertical_scale({}, {0.1, 0.93})), ElementsAre("0", "0.2", "0.4", "0.6", "0.8", "1"));
  EXPECT_THAT(labels(vertical_scale({"", false, true, {}, 1.0}, {0.5})),
              ElementsAre("0 %", "20 %", "40 %", "60 %", "80 %", "100 %"));
  EXPECT_THAT(labels(horizontal_scale({}, {0, 60000})),
              ElementsAre("0", "10,000", "20,000", "30,000", "40,000", "50,000", "60,000"));
  EXPECT_THAT(labels(horizontal_scale({"", true, false, {}, {}}, {0.5, 170000})),
              ElementsAre("1", "10", "100", "1,000", "10,000", "100,000"));
}

TEST(Scale, PutsValuesInTheirPlaces) {
  const Scale log = horizontal_scale({"", true, false, 1.0, 10000.0}, {});
  EXPECT_DOUBLE_EQ(log.at(100), 0.5);
  EXPECT_TRUE(std::isnan(log.at(0))) << "zero has no place on a logarithmic axis";
  const Scale linear = vertical_scale({"", false, false, 0.0, 2.0}, {});
  EXPECT_DOUBLE_EQ(linear.at(0.5), 0.25);
  EXPECT_DOUBLE_EQ(linear.at(7), 1) << "what is beyond the axis stays inside the picture";
  EXPECT_TRUE(std::isnan(linear.at(kAbsent)));
}

TEST(Scale, TakesNothingOneValueAndEqualOnes) {
  for (const std::vector<double>& values :
       {std::vector<double>{}, {3.0}, {3.0, 3.0}, {kAbsent}, {0.0, 0.0}}) {
    for (const bool log : {false, true}) {
      const ChartAxis axis{"", log, false, {}, {}};
      EXPECT_GT(horizontal_scale(axis, values).high, horizontal_scale(axis, values).low);
      EXPECT_FALSE(vertical_scale(axis, values).ticks.empty());
    }
  }
}

Figure bars() {
  Chart chart;
  chart.categories = {"cylinder", "a name that is much too long for the room it has"};
  chart.bars = {{"with", 0, {{0.9, 0.8, 1, {0.8, 0.9, 1}, 0.89}, {0.5}}}, {"without", 1, {{0.1}, {}}}};
  chart.y.percent = true;
  chart.levels = {{0.7, "level"}, {0.69, "another"}};
  return {"bars", "thesis", {chart, chart, chart}, 2};
}

// As deep as XML must nest, and as it must quote: what a browser would refuse.
TEST(SvgFigure, IsWellFormed) {
  const std::string svg = to_svg(bars()).value();
  std::vector<std::string> open;
  for (std::size_t at = svg.find('<'); at != std::string::npos; at = svg.find('<', at + 1)) {
    const std::size_t end = svg.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = svg.substr(at + 1, end - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" \n/"));
    if (tag.starts_with("/")) {
      ASSERT_FALSE(open.empty());
      EXPECT_EQ(open.back(), tag.substr(1));
      open.pop_back();
    } else if (!tag.ends_with("/")) {
      open.push_back(name);
    }
    EXPECT_EQ(std::ranges::count(tag, '"') % 2, 0) << tag;
  }
  EXPECT_TRUE(open.empty());
}

TEST(FigureLayout, GridHoldsEveryChartAndLegendNamesEachOnce) {
  const FigureLayout layout = lay_out(bars());
  std::vector<std::string> words;
  for (const LegendEntry& entry : layout.legend) {
    words.push_back(entry.words);
    EXPECT_LT(entry.x, layout.width);
  }
  EXPECT_THAT(words, ElementsAre("with", "without", "thesis"));
  EXPECT_EQ(layout.width, 2 * layout.cell_width);
  EXPECT_EQ(layout.height, layout.top + 2 * layout.cell_height);
}

TEST(FigureLayout, LongLegendsTakeMoreLines) {
  Figure figure = bars();
  for (int i = 0; i < 12; ++i)
    figure.charts[0].bars.push_back({"a rather long name of series " + std::to_string(i), i, {}});
  const FigureLayout layout = lay_out(figure);
  EXPECT_GT(layout.top, lay_out(bars()).top);
  for (const LegendEntry& entry : layout.legend) EXPECT_LT(entry.x + 60, layout.width);
}

// Nothing to draw is no reason to fail.
TEST(SvgFigure, TakesEmptyChartsAndValuesThatAreNone) {
  Figure figure;
  EXPECT_THAT(to_svg(figure).value(), HasSubstr("<svg"));
  Chart chart;
  chart.lines = {{"none", 0, {}}, {"odd", 1, {{kAbsent, 1}, {1, kAbsent}, {HUGE_VAL, 2}}}};
  chart.x.log = chart.y.log = true;
  figure.charts = {chart};
  const std::string svg = to_svg(figure).value();
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

}  // namespace
}  // namespace evograsp::cli

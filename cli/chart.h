// Pictures of numbers: one model of a figure, drawn the same way as PNG and as SVG.
//
// A figure is a grid of charts that share one legend. A chart shows lines (each with a band about it), or
// groups of bars (each with an interval and the single values it sums up), and values to compare with: dashed
// levels and diamonds. Colours are those of Okabe and Ito (2008), told apart by colour-blind readers too;
// lines differ in their dashes besides.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"

namespace evograsp::cli {

inline constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();  // a value that is not drawn

struct ChartAxis {
  std::string label;
  bool log = false;      // base 10; values that are not above zero are left out
  bool percent = false;  // 0.25 reads "25 %"
  // Ends; absent: vertical ones are 0 (or the smallest value below it) and a round number, horizontal ones
  // the data's.
  std::optional<double> low, high;
};

struct LinePoint {
  double x = 0, y = 0;
  double low = kAbsent, high = kAbsent;  // of the band
};
// Lines and bars of one name have one entry in the legend and one colour (an index: any number may be given).
struct ChartLine {
  std::string name;
  int colour = 0;
  std::vector<LinePoint> points;  // by x, ascending
  bool dots = false;              // a dot at each point
};

struct Bar {
  double value = kAbsent;
  double low = kAbsent, high = kAbsent;  // of the interval
  std::vector<double> dots = {};         // what the value sums up
  double reference = kAbsent;            // a diamond
};
struct BarSeries {
  std::string name;
  int colour = 0;
  std::vector<Bar> bars;  // one a category of the chart
};

struct Level {  // a dashed line from side to side
  double y = 0;
  std::string label;
};
struct Diamond {
  double x = 0, y = 0;
};

struct Chart {
  std::string title;
  ChartAxis x, y;
  std::vector<ChartLine> lines;
  std::vector<std::string> categories;  // of bars
  std::vector<BarSeries> bars;
  std::vector<Level> levels;
  std::vector<Diamond> diamonds;
};

struct Figure {
  std::string title;
  std::string reference;  // what diamonds stand for, in the legend
  std::vector<Chart> charts;
  int columns = 1;
};

Status write_png(const Figure& figure, const std::filesystem::path& path);
// An <svg> element of its own, text as outlines: looks the same wherever it is shown. Two of them in one HTML
// document must be kept apart (<img>): their outlines carry the same names.
Result<std::string> to_svg(const Figure& figure);

// Ends of an axis that holds `largest`: 1, or 1, 2, 2.5 or 5 times a power of ten.
double axis_end(double largest);

}  // namespace evograsp::cli

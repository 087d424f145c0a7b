// From values to places along an axis, and which of them get a number.
#pragma once

#include <string>
#include <vector>

#include "cli/chart.h"

namespace evograsp::cli {

struct Tick {
  double value = 0;
  std::string label;
};

struct Scale {
  double low = 0, high = 1;
  bool log = false;
  std::vector<Tick> ticks;  // ascending, within the ends

  // 0 at the low end, 1 at the high one, clamped; NaN for what cannot be shown.
  double at(double value) const;
};

// Of the horizontal axis: from the smallest value to the largest.
Scale horizontal_scale(const ChartAxis& axis, const std::vector<double>& values);
// Of the vertical axis: from zero to a round number.
Scale vertical_scale(const ChartAxis& axis, const std::vector<double>& values);

// "0.25", "25 %", "60,000", "1e-05".
std::string axis_number(double value, bool percent);

}  // namespace evograsp::cli

#include "cli/chart_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cli/progress.h"

namespace evograsp::cli {
namespace {

constexpr int kMostTicks = 7;

struct Ends {
  double low = 0, high = 0;
  bool any = false;
};

Ends ends_of(const std::vector<double>& values, bool log) {
  Ends ends;
  for (const double v : values) {
    if (!std::isfinite(v) || (log && v <= 0)) continue;
    ends.low = ends.any ? std::min(ends.low, v) : v;
    ends.high = ends.any ? std::max(ends.high, v) : v;
    ends.any = true;
  }
  return ends;
}

// The largest round step that still gives few ticks: 1, 2, 2.5 or 5 times a power of ten.
double round_step(double span, int most) {
  const double power = std::pow(10.0, std::floor(std::log10(span / most)));
  for (const double factor : {1.0, 2.0, 2.5, 5.0, 10.0}) {
    if (span / (factor * power) <= most) return factor * power;
  }
  return 10 * power;
}

void add_linear_ticks(Scale& scale, bool percent) {
  const double step = round_step(scale.high - scale.low, kMostTicks - 1);
  for (double k = std::ceil(scale.low / step - 1e-9); k * step <= scale.high + 1e-9 * step; ++k)
    scale.ticks.push_back({k * step, axis_number(k * step, percent)});
}

// Powers of ten; twice and five times them too when there is room.
void add_log_ticks(Scale& scale, bool percent) {
  const double decades = std::log10(scale.high / scale.low);
  for (double k = std::floor(std::log10(scale.low)); k <= std::ceil(std::log10(scale.high)); ++k) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10.0, k);
      if (value < scale.low * (1 - 1e-9) || value > scale.high * (1 + 1e-9)) continue;
      if (factor != 1 && decades > 2.2) continue;
      scale.ticks.push_back({value, axis_number(value, percent)});
    }
  }
}

void add_ticks(Scale& scale, bool percent) {
  if (!(scale.high > scale.low)) scale.high = scale.low + (scale.low == 0 ? 1 : std::abs(scale.low));
  scale.log ? add_log_ticks(scale, percent) : add_linear_ticks(scale, percent);
}

}  // namespace

double Scale::at(double value) const {
  if (!std::isfinite(value) || (log && value <= 0)) return kAbsent;
  const double part = log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return std::clamp(part, 0.0, 1.0);
}

Scale horizontal_scale(const ChartAxis& axis, const std::vector<double>& values) {
  const Ends ends = ends_of(values, axis.log);
  Scale scale;
  scale.log = axis.log;
  scale.low = axis.low.value_or(ends.any ? ends.low : axis.log ? 1 : 0);
  scale.high = axis.high.value_or(ends.any ? ends.high : axis.log ? 10 : 1);
  add_ticks(scale, axis.percent);
  return scale;
}

Scale vertical_scale(const ChartAxis& axis, const std::vector<double>& values) {
  const Ends ends = ends_of(values, axis.log);
  Scale scale;
  scale.log = axis.log;
  if (axis.log) {
    scale.low = axis.low.value_or(ends.any ? std::pow(10.0, std::floor(std::log10(ends.low))) : 1);
    scale.high = axis.high.value_or(ends.any ? std::pow(10.0, std::ceil(std::log10(ends.high))) : 10);
  } else {
    const double step = round_step(std::max(1e-12, std::max(ends.high, 0.0) - std::min(ends.low, 0.0)), 5);
    scale.low = axis.low.value_or(std::floor(std::min(ends.low, 0.0) / step) * step);
    scale.high = axis.high.value_or(ends.any ? std::ceil(ends.high / step - 1e-9) * step : 1);
  }
  add_ticks(scale, axis.percent);
  return scale;
}

std::string axis_number(double value, bool percent) {
  char text[40];
  if (std::abs(value) < 1e-12) value = 0;  // no minus, no 1e-17
  if (percent) {
    std::snprintf(text, sizeof text, "%.4g %%", 100 * value);
    return text;
  }
  const bool whole = std::floor(value) == value;
  if (whole && value >= 1000 && value < 1e9) return with_commas(static_cast<std::uint64_t>(value));
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

double axis_end(double largest) {
  if (!(largest > 1)) return 1;
  double power = 1;
  while (power * 10 < largest) power *= 10;
  for (const double step : {1.0, 2.0, 2.5, 5.0}) {
    if (step * power >= largest) return step * power;
  }
  return 10 * power;
}

}  // namespace evograsp::cli

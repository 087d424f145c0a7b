#include "cli/plot.h"

#include <algorithm>

namespace evograsp::cli {

Figure figure_of(const FitnessPlot& plot) {
  ChartLine best{"best", 0, {}}, mean{"mean", 1, {}};
  double largest = 0;
  for (const FitnessPoint& point : plot.points) {
    best.points.push_back({static_cast<double>(point.generation), point.best});
    mean.points.push_back({static_cast<double>(point.generation), point.mean});
    largest = std::max(largest, point.best);
  }
  Chart chart;
  chart.x.label = "generation";
  chart.x.low = 0;
  if (plot.points.size() < 2) chart.x.high = 1;
  chart.y.label = "fitness";
  chart.y.low = 0;
  chart.y.high = axis_end(largest);
  chart.lines = {best, mean};
  Figure figure;
  figure.title = plot.title;
  figure.charts = {chart};
  return figure;
}

}  // namespace evograsp::cli

#include <algorithm>
#include <cmath>
#include <memory>

#include "cli/chart_draw.h"

namespace evograsp::cli {
namespace {

constexpr double kMargin = 20, kTitleSize = 17, kLegendSize = 13;
constexpr double kSwatch = 26, kLegendGap = 22, kLegendLine = 21;

void add_once(std::vector<LegendEntry>& legend, LegendEntry entry) {
  const auto same = [&entry](const LegendEntry& e) { return e.words == entry.words; };
  if (entry.words.empty() || std::ranges::any_of(legend, same)) return;
  legend.push_back(std::move(entry));
}

bool has_reference(const Chart& chart) {
  if (!chart.diamonds.empty()) return true;
  return std::ranges::any_of(chart.bars, [](const BarSeries& series) {
    return std::ranges::any_of(series.bars, [](const Bar& bar) { return std::isfinite(bar.reference); });
  });
}

std::vector<LegendEntry> entries(const Figure& figure) {
  std::vector<LegendEntry> legend;
  for (const Chart& chart : figure.charts) {
    for (const ChartLine& line : chart.lines)
      add_once(legend, {LegendEntry::Kind::kLine, line.name, line.colour});
    for (const BarSeries& series : chart.bars)
      add_once(legend, {LegendEntry::Kind::kBar, series.name, series.colour});
  }
  if (std::ranges::any_of(figure.charts, has_reference))
    add_once(legend, {LegendEntry::Kind::kDiamond, figure.reference});
  return legend;
}

}  // namespace

FigureLayout lay_out(const Figure& figure) {
  using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
  using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;
  const Surface scratch(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1), cairo_surface_destroy);
  const Context context(cairo_create(scratch.get()), cairo_destroy);
  Pen pen(context.get());

  FigureLayout layout;
  const int columns = std::max(1, figure.columns);
  const int rows = std::max(1, (static_cast<int>(figure.charts.size()) + columns - 1) / columns);
  layout.cell_width = columns == 1 ? 900 : columns == 2 ? 540 : 400;
  layout.cell_height = columns == 1 && rows == 1 ? 420 : 320;
  layout.width = columns * layout.cell_width;

  layout.legend = entries(figure);
  if (layout.legend.size() == 1 && layout.legend[0].kind != LegendEntry::Kind::kDiamond)
    layout.legend.clear();
  const double title_end = kMargin + pen.text_width(figure.title, kTitleSize, true) + 2 * kLegendGap;
  double needed = 0;
  for (const LegendEntry& entry : layout.legend)
    needed += kSwatch + pen.text_width(entry.words, kLegendSize) + kLegendGap;
  // Beside the title when it fits there, else in lines below it.
  const bool beside = title_end + needed <= layout.width;
  double x = beside ? layout.width - needed : kMargin, y = beside ? 30 : 30 + kLegendLine + 3;
  for (LegendEntry& entry : layout.legend) {
    const double width = kSwatch + pen.text_width(entry.words, kLegendSize) + kLegendGap;
    if (x > kMargin && x + width - kLegendGap > layout.width) {
      x = kMargin;
      y += kLegendLine;
    }
    entry.x = x;
    entry.y = y;
    x += width;
  }
  layout.top = (layout.legend.empty() ? 30 : y) + 12;
  layout.height = layout.top + rows * layout.cell_height;
  return layout;
}

}  // namespace evograsp::cli

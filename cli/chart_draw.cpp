#include "cli/chart_draw.h"

#include <algorithm>
#include <cmath>

#include "cli/chart_scale.h"

namespace evograsp::cli {
namespace {

constexpr double kTickSize = 12, kLabelSize = 13, kSmall = 11;
constexpr double kTurnedLabels = -0.6;  // rad
constexpr std::size_t kLongestCategory = 24;

// The area that values are drawn in.
struct Area {
  double left, right, top, bottom;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
};

std::string shortened(const std::string& words) {
  return words.size() <= kLongestCategory ? words : words.substr(0, kLongestCategory - 1) + "…";
}

std::vector<double> all_y(const Chart& chart) {
  std::vector<double> values;
  for (const ChartLine& line : chart.lines) {
    for (const LinePoint& p : line.points) values.insert(values.end(), {p.y, p.low, p.high});
  }
  for (const BarSeries& series : chart.bars) {
    for (const Bar& bar : series.bars) {
      values.insert(values.end(), {bar.value, bar.low, bar.high, bar.reference});
      values.insert(values.end(), bar.dots.begin(), bar.dots.end());
    }
  }
  for (const Level& level : chart.levels) values.push_back(level.y);
  for (const Diamond& diamond : chart.diamonds) values.push_back(diamond.y);
  return values;
}

std::vector<double> all_x(const Chart& chart) {
  std::vector<double> values;
  for (const ChartLine& line : chart.lines) {
    for (const LinePoint& p : line.points) values.push_back(p.x);
  }
  for (const Diamond& diamond : chart.diamonds) values.push_back(diamond.x);
  return values;
}

class ChartDrawing {
 public:
  ChartDrawing(Pen& pen, const Chart& chart, Area cell) : pen_(pen), chart_(chart), cell_(cell) {}
  void draw();

 private:
  bool of_bars() const { return !chart_.categories.empty(); }
  double slot() const { return area_.width() / static_cast<double>(chart_.categories.size()); }
  double px(double value) const { return area_.left + area_.width() * x_.at(value); }
  double py(double value) const { return area_.bottom - area_.height() * y_.at(value); }
  void make_room();
  void draw_frame();
  void draw_x_numbers();
  void draw_categories();
  void draw_band(const ChartLine& line);
  void draw_line(const ChartLine& line);
  void draw_bar(const Bar& bar, double x, double width, int colour);
  void draw_bars();
  void draw_levels();

  Pen& pen_;
  const Chart& chart_;
  const Area cell_;
  Area area_{};
  Scale x_, y_;
  bool turned_ = false;  // category labels
};

// Scales, and how much of the cell their numbers and words take.
void ChartDrawing::make_room() {
  x_ = horizontal_scale(chart_.x, all_x(chart_));
  y_ = vertical_scale(chart_.y, all_y(chart_));
  double numbers = 0;
  for (const Tick& tick : y_.ticks) numbers = std::max(numbers, pen_.text_width(tick.label, kTickSize));
  area_ = {cell_.left + 12 + numbers + (chart_.y.label.empty() ? 8 : 30), cell_.right - 22,
           cell_.top + (chart_.title.empty() ? 12 : 34), cell_.bottom - (chart_.x.label.empty() ? 30 : 50)};
  if (!of_bars()) return;
  double widest = 0;
  for (const std::string& name : chart_.categories)
    widest = std::max(widest, pen_.text_width(shortened(name), kTickSize));
  turned_ = widest + 8 > slot();
  if (turned_) area_.bottom -= std::max(0.0, widest * std::sin(-kTurnedLabels) - 4);
}

void ChartDrawing::draw_frame() {
  pen_.use(kInk);
  if (!chart_.title.empty()) pen_.text(area_.left, cell_.top + 20, chart_.title, 14, TextAlign::kLeft, true);
  for (const Tick& tick : y_.ticks) {
    pen_.use(kGrid);
    pen_.line(area_.left, py(tick.value), area_.right, py(tick.value), 1);
    pen_.use(kInk);
    pen_.text(area_.left - 8, py(tick.value) + 4, tick.label, kTickSize, TextAlign::kRight);
  }
  pen_.use(kPaleInk);
  pen_.line(area_.left, area_.bottom, area_.right, area_.bottom, 1);
  pen_.use(kInk);
  if (!chart_.y.label.empty())
    pen_.turned_text(cell_.left + 20, (area_.top + area_.bottom) / 2, chart_.y.label, kLabelSize,
                     -1.5707963267948966, TextAlign::kCentre);
  if (!chart_.x.label.empty())
    pen_.text((area_.left + area_.right) / 2, cell_.bottom - 12, chart_.x.label, kLabelSize,
              TextAlign::kCentre);
}

// Numbers that would touch the one before them are left out; the marks stay.
void ChartDrawing::draw_x_numbers() {
  double taken = -1e9;
  for (const Tick& tick : x_.ticks) {
    const double x = px(tick.value), half = pen_.text_width(tick.label, kTickSize) / 2;
    pen_.use(kPaleInk);
    pen_.line(x, area_.bottom, x, area_.bottom + 4, 1);
    if (x - half < taken + 8) continue;
    pen_.use(kInk);
    pen_.text(x, area_.bottom + 18, tick.label, kTickSize, TextAlign::kCentre);
    taken = x + half;
  }
}

void ChartDrawing::draw_categories() {
  pen_.use(kInk);
  for (std::size_t i = 0; i < chart_.categories.size(); ++i) {
    const double x = area_.left + slot() * (static_cast<double>(i) + 0.5);
    const std::string words = shortened(chart_.categories[i]);
    if (turned_) {
      pen_.turned_text(x + 5, area_.bottom + 14, words, kTickSize, kTurnedLabels, TextAlign::kRight);
    } else {
      pen_.text(x, area_.bottom + 18, words, kTickSize, TextAlign::kCentre);
    }
  }
}

void ChartDrawing::draw_band(const ChartLine& line) {
  cairo_t* c = pen_.context();
  std::vector<const LinePoint*> known;
  for (const LinePoint& p : line.points) {
    if (std::isfinite(p.low) && std::isfinite(p.high) && std::isfinite(x_.at(p.x)) &&
        std::isfinite(y_.at(p.low)) && std::isfinite(y_.at(p.high)))
      known.push_back(&p);
  }
  if (known.size() < 2) return;
  for (const LinePoint* p : known) cairo_line_to(c, px(p->x), py(p->high));
  for (auto p = known.rbegin(); p != known.rend(); ++p) cairo_line_to(c, px((*p)->x), py((*p)->low));
  cairo_close_path(c);
  pen_.use(series_colour(line.colour), 0.16);
  cairo_fill(c);
}

void ChartDrawing::draw_line(const ChartLine& line) {
  cairo_t* c = pen_.context();
  pen_.use(series_colour(line.colour));
  cairo_set_line_width(c, 2.2);
  use_dashes(c, line.colour);
  int drawn = 0;
  for (const LinePoint& p : line.points) {
    if (!std::isfinite(x_.at(p.x)) || !std::isfinite(y_.at(p.y))) continue;
    cairo_line_to(c, px(p.x), py(p.y));
    ++drawn;
  }
  cairo_stroke(c);
  cairo_set_dash(c, nullptr, 0, 0);
  if (!line.dots && drawn > 1) return;
  for (const LinePoint& p : line.points) {
    if (std::isfinite(x_.at(p.x)) && std::isfinite(y_.at(p.y))) pen_.dot(px(p.x), py(p.y), 3.2);
  }
}

void ChartDrawing::draw_bar(const Bar& bar, double x, double width, int colour) {
  const double middle = x + width / 2;
  if (std::isfinite(y_.at(bar.value))) {
    pen_.use(series_colour(colour));
    pen_.rectangle(x, py(bar.value), width, std::max(1.0, area_.bottom - py(bar.value)));
  }
  if (std::isfinite(y_.at(bar.low)) && std::isfinite(y_.at(bar.high))) {
    const double cap = std::min(5.0, width / 3);
    pen_.use(kInk);
    pen_.line(middle, py(bar.low), middle, py(bar.high), 1.3);
    pen_.line(middle - cap, py(bar.low), middle + cap, py(bar.low), 1.3);
    pen_.line(middle - cap, py(bar.high), middle + cap, py(bar.high), 1.3);
  }
  pen_.use(kInk, 0.55);
  for (const double value : bar.dots) {
    if (std::isfinite(y_.at(value))) pen_.dot(middle, py(value), std::min(2.0, width / 4));
  }
}

void ChartDrawing::draw_bars() {
  const double count = static_cast<double>(std::max<std::size_t>(1, chart_.bars.size()));
  const double width = std::min(44.0, 0.8 * slot() / count), gap = std::min(2.0, 0.1 * width);
  for (const bool references : {false, true}) {
    for (std::size_t s = 0; s < chart_.bars.size(); ++s) {
      const BarSeries& series = chart_.bars[s];
      for (std::size_t i = 0; i < std::min(series.bars.size(), chart_.categories.size()); ++i) {
        const double x = area_.left + slot() * (static_cast<double>(i) + 0.5) +
                         width * (static_cast<double>(s) - count / 2);
        if (!references) draw_bar(series.bars[i], x, width - gap, series.colour);
        if (references && std::isfinite(y_.at(series.bars[i].reference)))
          pen_.diamond(x + (width - gap) / 2, py(series.bars[i].reference), 4.5);
      }
    }
  }
}

// A label stands above its line, at the left end; below it when another one is there.
void ChartDrawing::draw_levels() {
  std::vector<double> taken;
  for (const Level& level : chart_.levels) {
    const double y = py(level.y);
    if (!std::isfinite(y)) continue;
    pen_.use(kInk, 0.8);
    const double dashes[] = {5, 4};
    cairo_set_dash(pen_.context(), dashes, 2, 0);
    pen_.line(area_.left, y, area_.right, y, 1.2);
    cairo_set_dash(pen_.context(), nullptr, 0, 0);
    const auto near = [&taken](double at) {
      return std::ranges::any_of(taken, [at](double other) { return std::abs(other - at) < kSmall + 1; });
    };
    const double words = near(y - 4) || y - 4 - kSmall < area_.top ? y + kSmall + 3 : y - 4;
    taken.push_back(words);
    pen_.text(area_.left + 6, words, level.label, kSmall);
  }
}

void ChartDrawing::draw() {
  make_room();
  draw_frame();
  of_bars() ? draw_categories() : draw_x_numbers();
  for (const ChartLine& line : chart_.lines) draw_band(line);
  if (of_bars()) draw_bars();
  draw_levels();
  for (const ChartLine& line : chart_.lines) draw_line(line);
  for (const Diamond& d : chart_.diamonds) {
    if (std::isfinite(x_.at(d.x)) && std::isfinite(y_.at(d.y))) pen_.diamond(px(d.x), py(d.y), 6);
  }
}

void draw_legend(Pen& pen, const LegendEntry& entry) {
  switch (entry.kind) {
    case LegendEntry::Kind::kLine:
      pen.use(series_colour(entry.colour));
      use_dashes(pen.context(), entry.colour);
      pen.line(entry.x, entry.y - 4.5, entry.x + 20, entry.y - 4.5, 3);
      cairo_set_dash(pen.context(), nullptr, 0, 0);
      break;
    case LegendEntry::Kind::kBar:
      pen.use(series_colour(entry.colour));
      pen.rectangle(entry.x + 6, entry.y - 11, 14, 13);
      break;
    case LegendEntry::Kind::kDiamond:
      pen.diamond(entry.x + 13, entry.y - 4.5, 5);
  }
  pen.use(kInk);
  pen.text(entry.x + 26, entry.y, entry.words, 13);
}

}  // namespace

void draw(Pen& pen, const Figure& figure, const FigureLayout& layout) {
  pen.use({1, 1, 1});
  cairo_paint(pen.context());
  pen.use(kInk);
  pen.text(20, 30, figure.title, 17, TextAlign::kLeft, true);
  for (const LegendEntry& entry : layout.legend) draw_legend(pen, entry);
  const int columns = std::max(1, figure.columns);
  for (std::size_t i = 0; i < figure.charts.size(); ++i) {
    const int row = static_cast<int>(i) / columns, column = static_cast<int>(i) % columns;
    const double left = layout.cell_width * static_cast<double>(column);
    const double top = layout.top + layout.cell_height * static_cast<double>(row);
    ChartDrawing(pen, figure.charts[i], {left, left + layout.cell_width, top, top + layout.cell_height})
        .draw();
  }
}

}  // namespace evograsp::cli

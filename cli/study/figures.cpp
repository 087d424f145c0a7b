#include "cli/study/figures.h"

#include <algorithm>
#include <cmath>

#include "cli/judge.h"

namespace evograsp::cli::study {
namespace {

class FigureMaker {
 public:
  FigureMaker(const proto::Study& study, const proto::StudyPlot& plot, const Data& data)
      : study_(study), plot_(plot), data_(data.of(plot.source())) {}
  Figure make();

 private:
  // What one line or one colour of bars shows.
  struct Series {
    std::string y, name;
    Cell value;  // of the series axis; null without
  };
  std::vector<Series> series() const;
  bool wanted(std::size_t row) const {
    return std::ranges::all_of(plot_.where(), [this, row](const proto::StudyTag& tag) {
      return data_.at(row, tag.name()) == cell_of(tag.value());
    });
  }
  std::vector<std::size_t> rows(const Cell& panel, const Series& series) const;
  std::string axis_label(const std::string& axis, const Cell& value) const {
    return label_of(study_, axis, text_of(value));
  }
  Chart chart(const Cell& panel) const;
  void add_lines(Chart& chart, const Cell& panel) const;
  ChartLine line(const Series& series, const std::vector<std::size_t>& rows) const;
  void add_bars(Chart& chart, const Cell& panel) const;
  Bar bar(const Series& series, const std::vector<std::size_t>& rows) const;
  double reference(const Cell& panel, const Cell& x, const Cell& series) const;
  std::vector<Cell> values(const std::string& column) const;

  const proto::Study& study_;
  const proto::StudyPlot& plot_;
  const DataTable& data_;
};

// In the order of the study's axis, or of first appearance.
std::vector<Cell> FigureMaker::values(const std::string& column) const {
  std::vector<Cell> found;
  for (const Group& g : group(data_, {column})) {
    if (std::ranges::any_of(g.rows, [this](std::size_t row) { return wanted(row); }))
      found.push_back(g.key[0]);
  }
  for (const proto::StudyAxis& axis : study_.axis()) {
    if (axis.name() != column) continue;
    const auto place = [&axis](const Cell& cell) {
      for (int i = 0; i < axis.value_size(); ++i)
        if (cell_of(axis.value(i).name()) == cell) return i;
      return axis.value_size();
    };
    std::ranges::stable_sort(found, [&](const Cell& a, const Cell& b) { return place(a) < place(b); });
  }
  return found;
}

std::vector<FigureMaker::Series> FigureMaker::series() const {
  std::vector<Series> all;
  const auto y_name = [this](int i) { return plot_.y_name_size() > i ? plot_.y_name(i) : plot_.y(i); };
  if (plot_.series().empty()) {
    for (int i = 0; i < plot_.y_size(); ++i) all.push_back({plot_.y(i), y_name(i), {}});
    return all;
  }
  for (const Cell& value : values(plot_.series())) {
    for (int i = 0; i < plot_.y_size(); ++i) {
      const std::string name = axis_label(plot_.series(), value);
      all.push_back({plot_.y(i), plot_.y_size() > 1 ? name + ", " + y_name(i) : name, value});
    }
  }
  return all;
}

std::vector<std::size_t> FigureMaker::rows(const Cell& panel, const Series& series) const {
  std::vector<std::size_t> found;
  for (std::size_t row = 0; row < data_.rows.size(); ++row) {
    if (!wanted(row) || (!plot_.panel().empty() && data_.at(row, plot_.panel()) != panel)) continue;
    if (!plot_.series().empty() && data_.at(row, plot_.series()) != series.value) continue;
    found.push_back(row);
  }
  return found;
}

// A point where seeds meet: the same generation, or else the same x.
ChartLine FigureMaker::line(const Series& series, const std::vector<std::size_t>& rows) const {
  DataTable chosen;
  chosen.columns = {"step", "x", "y"};
  const std::string step = plot_.source() == proto::GENERATIONS ? "generation" : plot_.x();
  for (const std::size_t row : rows)
    chosen.rows.push_back({data_.at(row, step), data_.at(row, plot_.x()), data_.at(row, series.y)});
  ChartLine line{series.name, 0, {}};
  for (const Group& g : group(chosen, {"step"})) {
    const std::vector<double> y = numbers(chosen, g.rows, "y");
    if (y.empty()) continue;
    LinePoint point{median(numbers(chosen, g.rows, "x")), median(y)};
    if (y.size() > 1) {
      point.low = quantile(y, 0.25);
      point.high = quantile(y, 0.75);
    }
    line.points.push_back(point);
  }
  std::ranges::stable_sort(line.points, {}, &LinePoint::x);
  line.dots = line.points.size() <= 12;
  if (plot_.relative() && !line.points.empty()) {
    // A time becomes how many times faster than the first point it is.
    const double first = line.points.front().y;
    for (LinePoint& p : line.points) p = {p.x, first / p.y, first / p.high, first / p.low};
  }
  return line;
}

void FigureMaker::add_lines(Chart& chart, const Cell& panel) const {
  int colour = 0;
  for (const Series& s : series()) {
    ChartLine l = line(s, rows(panel, s));
    l.colour = colour++;
    if (!l.points.empty()) chart.lines.push_back(std::move(l));
  }
  for (const proto::StudyPoint& point : plot_.point())
    if (!point.has_panel() || cell_of(point.panel()) == panel)
      chart.diamonds.push_back({point.x(), point.y()});
}

Bar FigureMaker::bar(const Series& series, const std::vector<std::size_t>& rows) const {
  Bar bar;
  bar.dots = numbers(data_, rows, series.y);
  if (bar.dots.empty()) return bar;
  bar.value = median(bar.dots);
  if (bar.dots.size() > 1) {
    const Range range = median_interval(bar.dots);
    bar.low = range.low;
    bar.high = range.high;
    return bar;
  }
  bar.dots.clear();
  const std::string count = series.y == "success" ? "successes" : series.y == "lift_success" ? "lifts" : "";
  if (count.empty() || rows.empty()) return bar;
  const Interval i = wilson(static_cast<int>(number_of(data_.at(rows[0], count))),
                            static_cast<int>(number_of(data_.at(rows[0], "n"))));
  bar.low = i.low;
  bar.high = i.high;
  return bar;
}

double FigureMaker::reference(const Cell& panel, const Cell& x, const Cell& series) const {
  std::vector<Cell> wanted;
  if (!plot_.panel().empty()) wanted.push_back(panel);
  wanted.push_back(x);
  if (!plot_.series().empty()) wanted.push_back(series);
  for (const proto::StudyReference& reference : plot_.reference()) {
    bool same = reference.at_size() == static_cast<int>(wanted.size());
    for (std::size_t i = 0; same && i < wanted.size(); ++i)
      same = wanted[i] == cell_of(reference.at(static_cast<int>(i)));
    if (same) return reference.value();
  }
  return kAbsent;
}

void FigureMaker::add_bars(Chart& chart, const Cell& panel) const {
  std::vector<Cell> shown;
  for (const Cell& x : values(plot_.x())) {
    const auto here = [&](const Series& s) {
      return std::ranges::any_of(rows(panel, s),
                                 [&](std::size_t row) { return data_.at(row, plot_.x()) == x; });
    };
    if (std::ranges::any_of(series(), here)) shown.push_back(x);
  }
  for (const Cell& x : shown) chart.categories.push_back(axis_label(plot_.x(), x));
  int colour = 0;
  for (const Series& s : series()) {
    BarSeries bars{s.name, colour++, {}};
    const std::vector<std::size_t> of_series = rows(panel, s);
    for (const Cell& x : shown) {
      std::vector<std::size_t> chosen;
      std::ranges::copy_if(of_series, std::back_inserter(chosen),
                           [&](std::size_t row) { return data_.at(row, plot_.x()) == x; });
      Bar b = bar(s, chosen);
      if (s.y == plot_.y(0)) b.reference = reference(panel, x, s.value);
      bars.bars.push_back(std::move(b));
    }
    chart.bars.push_back(std::move(bars));
  }
}

Chart FigureMaker::chart(const Cell& panel) const {
  Chart chart;
  if (!plot_.panel().empty()) chart.title = axis_label(plot_.panel(), panel);
  const bool bars = plot_.kind() == proto::BARS;
  chart.x.label = plot_.has_x_label() ? plot_.x_label() : bars ? "" : plot_.x();
  chart.y.label = plot_.has_y_label() ? plot_.y_label() : plot_.y(0);
  chart.x.log = plot_.log_x();
  chart.y.log = plot_.log_y();
  chart.y.percent = plot_.percent();
  if (plot_.has_y_low()) chart.y.low = plot_.y_low();
  if (plot_.has_y_high()) chart.y.high = plot_.y_high();
  bars ? add_bars(chart, panel) : add_lines(chart, panel);
  for (const proto::StudyLevel& level : plot_.level())
    if (!level.has_panel() || cell_of(level.panel()) == panel)
      chart.levels.push_back({level.y(), level.label()});
  return chart;
}

Figure FigureMaker::make() {
  Figure figure;
  figure.title = plot_.title();
  figure.reference = plot_.reference_label();
  if (plot_.panel().empty()) {
    figure.charts.push_back(chart({}));
    return figure;
  }
  for (const Cell& panel : values(plot_.panel())) figure.charts.push_back(chart(panel));
  figure.columns = std::min(static_cast<int>(plot_.columns()),
                            static_cast<int>(std::max<std::size_t>(1, figure.charts.size())));
  return figure;
}

}  // namespace

Figure figure_of(const proto::Study& study, const proto::StudyPlot& plot, const Data& data) {
  return FigureMaker(study, plot, data).make();
}

}  // namespace evograsp::cli::study

#include "cli/heat_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cli/chart_pen.h"
#include "cli/chart_surface.h"
#include "cli/table.h"

namespace evograsp::cli {
namespace {

constexpr double kCell = 56, kCellHeight = 40, kLeft = 96, kTop = 64, kBottom = 64, kRight = 28, kSmall = 12;

double edge(const HeatAxis& axis, int bin) {
  return axis.low + (axis.high - axis.low) * bin / axis.bins;
}

// As many digits as tell the edges apart.
std::string edge_text(const HeatAxis& axis, int bin) {
  const double step = std::abs(axis.high - axis.low) / axis.bins;
  const int digits = step >= 1 ? (std::floor(step) == step ? 0 : 1) : step >= 0.1 ? 2 : 3;
  return fixed(edge(axis, bin), digits);
}

double largest(const HeatMap& map) {
  double most = 0;
  for (const double v : map.value)
    if (std::isfinite(v)) most = std::max(most, std::abs(v));
  return most;
}

// Two digits after the point of fitness up to 1, none of one in thousands.
std::string cell_text(double value, double most) {
  return std::isfinite(value) ? fixed(value, most < 10 ? 2 : most < 100 ? 1 : 0) : "";
}

double at(const HeatMap& map, int x, int y) {
  const std::size_t index =
      static_cast<std::size_t>(x) + static_cast<std::size_t>(y) * static_cast<std::size_t>(map.x.bins);
  return index < map.value.size() ? map.value[index] : std::nan("");
}

// From pale to dark blue-green, so that it also reads in grey.
Colour shade(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return {0.93 - 0.90 * s, 0.95 - 0.62 * s, 0.93 - 0.45 * s};
}

class Drawing {
 public:
  Drawing(Pen& pen, const HeatMap& map) : pen_(pen), map_(map), most_(largest(map)) {}

  void draw() {
    pen_.use({1, 1, 1});
    pen_.rectangle(0, 0, heat_width(map_), heat_height(map_));
    pen_.use(kInk);
    pen_.text(kLeft, 28, map_.title, 17, TextAlign::kLeft, true);
    pen_.use(kPaleInk);
    pen_.text(kLeft, 48, map_.value_label, 13);
    for (int y = 0; y < map_.y.bins; ++y)
      for (int x = 0; x < map_.x.bins; ++x) cell(x, y);
    edges();
  }

  static double heat_width(const HeatMap& map) { return kLeft + kCell * map.x.bins + kRight; }
  static double heat_height(const HeatMap& map) { return kTop + kCellHeight * map.y.bins + kBottom; }

 private:
  double left(int x) const { return kLeft + kCell * x; }
  double bottom(int y) const { return kTop + kCellHeight * (map_.y.bins - y); }

  void cell(int x, int y) {
    const double value = at(map_, x, y);
    const double share = most_ > 0 ? value / most_ : 0;
    pen_.use(std::isfinite(value) ? shade(share) : Colour{0.975, 0.975, 0.978});
    pen_.rectangle(left(x) + 1, bottom(y) - kCellHeight + 1, kCell - 2, kCellHeight - 2);
    if (!std::isfinite(value)) return;
    pen_.use(share > 0.5 ? Colour{1, 1, 1} : kInk);
    pen_.text(left(x) + kCell / 2, bottom(y) - kCellHeight / 2 + 4, cell_text(value, most_), 13,
              TextAlign::kCentre);
  }

  void edges() {
    pen_.use(kPaleInk);
    const double base = bottom(0);
    for (int x = 0; x <= map_.x.bins; ++x)
      pen_.text(left(x), base + 18, edge_text(map_.x, x), kSmall, TextAlign::kCentre);
    for (int y = 0; y <= map_.y.bins; ++y)
      pen_.text(kLeft - 8, bottom(y) + 4, edge_text(map_.y, y), kSmall, TextAlign::kRight);
    pen_.use(kInk);
    pen_.text((left(0) + left(map_.x.bins)) / 2, base + 44, map_.x.label, 13, TextAlign::kCentre);
    constexpr double kUp = -1.5707963267948966;
    pen_.turned_text(26, (bottom(0) + bottom(map_.y.bins)) / 2, map_.y.label, 13, kUp, TextAlign::kCentre);
  }

  Pen& pen_;
  const HeatMap& map_;
  const double most_;
};

}  // namespace

std::string to_text(const HeatMap& map) {
  const double most = largest(map);
  std::size_t width = 4, margin = 0;
  for (int x = 0; x < map.x.bins; ++x) {
    width = std::max(width, edge_text(map.x, x).size());
    for (int y = 0; y < map.y.bins; ++y) width = std::max(width, cell_text(at(map, x, y), most).size());
  }
  for (int y = 0; y < map.y.bins; ++y) margin = std::max(margin, edge_text(map.y, y).size());
  const auto right = [](const std::string& text, std::size_t columns) {
    return std::string(columns > text.size() ? columns - text.size() : 0, ' ') + text;
  };
  std::string out = map.y.label + "\n";
  for (int y = map.y.bins - 1; y >= 0; --y) {
    out += right(edge_text(map.y, y), margin) + " |";
    for (int x = 0; x < map.x.bins; ++x) {
      const std::string value = cell_text(at(map, x, y), most);
      out += " " + right(value.empty() ? "." : value, width);
    }
    out += "\n";
  }
  out += std::string(margin + 1, ' ') + "+" +
         std::string((width + 1) * static_cast<std::size_t>(map.x.bins), '-');
  out += "\n" + std::string(margin + 2, ' ');
  for (int x = 0; x < map.x.bins; ++x) out += " " + right(edge_text(map.x, x), width);
  return out + "  " + map.x.label + "\n";
}

Status write_png(const HeatMap& map, const std::filesystem::path& path) {
  const CanvasSize size{Drawing::heat_width(map), Drawing::heat_height(map)};
  return draw_png(size, path, [&](Pen& pen) { Drawing(pen, map).draw(); });
}

Result<std::string> to_svg(const HeatMap& map) {
  const CanvasSize size{Drawing::heat_width(map), Drawing::heat_height(map)};
  return draw_svg(size, [&](Pen& pen) { Drawing(pen, map).draw(); });
}

}  // namespace evograsp::cli

// The plot in characters: each is a cell of 2 x 4 Braille dots, so that 64 x 13 characters show 128 x 52
// points.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cli/plot.h"

namespace evograsp::cli {
namespace {

class Canvas {
 public:
  Canvas(int columns, int rows)
      : columns_(columns), rows_(rows), cells_(static_cast<std::size_t>(columns) * rows) {}
  int width() const { return 2 * columns_; }
  int height() const { return 4 * rows_; }

  // y counts from the bottom.
  void dot(int x, int y) {
    if (x < 0 || x >= width() || y < 0 || y >= height()) return;
    static constexpr unsigned char kBits[4][2] = {{0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}};
    const int from_top = height() - 1 - y;
    cells_[static_cast<std::size_t>(from_top / 4) * columns_ + x / 2] |= kBits[from_top % 4][x % 2];
  }

  std::string row(int index) const {
    std::string out;
    for (int i = 0; i < columns_; ++i) {
      const unsigned char bits = cells_[static_cast<std::size_t>(index) * columns_ + i];
      if (bits == 0) {
        out += ' ';
        continue;
      }
      // U+2800 + bits in UTF-8.
      out += '\xe2';
      out += static_cast<char>(0xa0 | (bits >> 6));
      out += static_cast<char>(0x80 | (bits & 0x3f));
    }
    return out;
  }

 private:
  int columns_, rows_;
  std::vector<unsigned char> cells_;
};

// Straight lines between points, every `step`-th column of dots drawn.
void draw(Canvas& canvas, const FitnessPlot& plot, double FitnessPoint::*value, double top, int step) {
  const double last = std::max<double>(1, plot.points.back().generation);
  const auto y_of = [&](double fitness) {
    return static_cast<int>(std::lround(std::clamp(fitness / top, 0.0, 1.0) * (canvas.height() - 1)));
  };
  std::size_t at = 0;
  int previous = -1;
  for (int x = 0; x < canvas.width(); ++x) {
    const double generation = last * x / (canvas.width() - 1);
    while (at + 1 < plot.points.size() && plot.points[at + 1].generation <= generation) ++at;
    const FitnessPoint& a = plot.points[at];
    const FitnessPoint& b = plot.points[std::min(at + 1, plot.points.size() - 1)];
    const double span = static_cast<double>(b.generation) - a.generation;
    const double part = span > 0 ? std::clamp((generation - a.generation) / span, 0.0, 1.0) : 0;
    const int y = y_of(a.*value + part * (b.*value - a.*value));
    if (x % step == 0) {
      const int from = previous < 0 || step > 1 ? y : previous;
      for (int k = std::min(from, y); k <= std::max(from, y); ++k) canvas.dot(x, k);
    }
    previous = y;
  }
}

}  // namespace

int plot_columns(int terminal_columns) {
  return std::clamp(terminal_columns - 12, 20, 64);
}

std::string to_text(const FitnessPlot& plot, int columns, int rows) {
  if (plot.points.empty()) return "(no generation yet)\n";
  double largest = 0;
  for (const FitnessPoint& point : plot.points) largest = std::max(largest, point.best);
  const double top = axis_end(largest);
  Canvas canvas(columns, rows);
  draw(canvas, plot, &FitnessPoint::mean, top, 3);
  draw(canvas, plot, &FitnessPoint::best, top, 1);

  std::string out = "  fitness (line: best, dots: mean)\n";
  for (int row = 0; row < rows; ++row) {
    char label[16] = "        ";
    const bool labelled = row == 0 || row == rows - 1 || (row == rows / 2 && rows > 4);
    const double at_row = top * (rows - 1 - row) / (rows - 1);
    if (labelled) std::snprintf(label, sizeof label, "%8.3g", at_row);
    out += std::string(label) + (labelled ? " ┤" : " │") + canvas.row(row) + "\n";
  }
  std::string axis;
  for (int i = 0; i < columns; ++i) axis += "─";
  const std::string last = std::to_string(plot.points.back().generation);
  const int gap = std::max(1, columns - 1 - static_cast<int>(last.size()));
  const std::string caption = "generation";
  std::string feet = "0" + std::string(static_cast<std::size_t>(gap), ' ') + last;
  if (gap > static_cast<int>(caption.size()) + 2)
    feet.replace(1 + (gap - caption.size()) / 2, caption.size(), caption);
  return out + std::string(9, ' ') + "└" + axis + "\n" + std::string(10, ' ') + feet + "\n";
}

}  // namespace evograsp::cli

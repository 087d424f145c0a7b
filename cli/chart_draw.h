// A figure's places on the canvas, and its drawing.
#pragma once

#include <vector>

#include "cli/chart.h"
#include "cli/chart_pen.h"

namespace evograsp::cli {

struct LegendEntry {
  enum class Kind { kLine, kBar, kDiamond } kind = Kind::kLine;
  std::string words;
  int colour = 0;
  double x = 0, y = 0;  // of the swatch's left end, on the line that letters stand on
};

// Pixels; y downward.
struct FigureLayout {
  double width = 0, height = 0;
  double top = 0;  // where charts begin
  double cell_width = 0, cell_height = 0;
  std::vector<LegendEntry> legend;
};
// Measures with a canvas of its own.
FigureLayout lay_out(const Figure& figure);
void draw(Pen& pen, const Figure& figure, const FigureLayout& layout);

}  // namespace evograsp::cli

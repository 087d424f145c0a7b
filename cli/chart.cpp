#include "cli/chart.h"

#include "cli/chart_draw.h"
#include "cli/chart_surface.h"

namespace evograsp::cli {

Status write_png(const Figure& figure, const std::filesystem::path& path) {
  const FigureLayout layout = lay_out(figure);
  return draw_png({layout.width, layout.height}, path, [&](Pen& pen) { draw(pen, figure, layout); });
}

Result<std::string> to_svg(const Figure& figure) {
  const FigureLayout layout = lay_out(figure);
  return draw_svg({layout.width, layout.height}, [&](Pen& pen) { draw(pen, figure, layout); });
}

}  // namespace evograsp::cli

// Where pens draw: an image file, or an SVG element.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "cli/chart_pen.h"
#include "common/result.h"

namespace evograsp::cli {

struct CanvasSize {
  double width = 0, height = 0;  // px
};

Status draw_png(CanvasSize size, const std::filesystem::path& path, const std::function<void(Pen&)>& draw);
// An <svg> element of its own, without the XML declaration.
Result<std::string> draw_svg(CanvasSize size, const std::function<void(Pen&)>& draw);

}  // namespace evograsp::cli

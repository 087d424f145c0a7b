#include "cli/plot.h"

#include <cairo-svg.h>
#include <cairo.h>

#include <algorithm>
#include <cstdio>
#include <memory>

namespace evograsp::cli {
namespace {

constexpr double kWidth = 900, kHeight = 480;
constexpr double kLeft = 64, kRight = 24, kTop = 52, kBottom = 52;

struct Colour {
  double r, g, b;
};
constexpr Colour kInk{0.13, 0.15, 0.18}, kGrid{0.88, 0.89, 0.91}, kBest{0.05, 0.42, 0.72},
    kMean{0.93, 0.55, 0.14};

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

void use(cairo_t* c, Colour colour, double alpha = 1) {
  cairo_set_source_rgba(c, colour.r, colour.g, colour.b, alpha);
}

// align: 0 left, 0.5 centred, 1 right.
void text(cairo_t* c, double x, double y, const std::string& words, double size, double align) {
  cairo_set_font_size(c, size);
  cairo_text_extents_t extents;
  cairo_text_extents(c, words.c_str(), &extents);
  cairo_move_to(c, x - align * extents.x_advance, y);
  cairo_show_text(c, words.c_str());
  cairo_new_path(c);  // or the pen's place after the last letter begins the next line
}

std::string number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

struct Axes {
  double last_generation, top;
  double x(double generation) const {
    return kLeft + (kWidth - kLeft - kRight) * generation / last_generation;
  }
  double y(double fitness) const {
    return kHeight - kBottom - (kHeight - kTop - kBottom) * std::clamp(fitness / top, 0.0, 1.0);
  }
};

void draw_axes(cairo_t* c, const Axes& axes) {
  cairo_set_line_width(c, 1);
  for (int i = 0; i <= 5; ++i) {
    const double fitness = axes.top * i / 5;
    use(c, kGrid);
    cairo_move_to(c, kLeft, axes.y(fitness));
    cairo_line_to(c, kWidth - kRight, axes.y(fitness));
    cairo_stroke(c);
    use(c, kInk);
    text(c, kLeft - 8, axes.y(fitness) + 4, number(fitness), 13, 1);
  }
  // Whole generations at a step of 1, 2 or 5 times a power of ten: at most ten of them.
  double step = 1;
  for (int i = 0; axes.last_generation / step > 10; ++i) step *= i % 3 == 1 ? 2.5 : 2;
  for (double generation = 0; generation <= axes.last_generation; generation += step)
    text(c, axes.x(generation), kHeight - kBottom + 20, number(generation), 13, 0.5);
  text(c, kLeft + (kWidth - kLeft - kRight) / 2, kHeight - 12, "generation", 14, 0.5);
}

void draw_curve(cairo_t* c, const Axes& axes, const FitnessPlot& plot, double FitnessPoint::*value,
                Colour colour) {
  use(c, colour);
  cairo_set_line_width(c, 2.2);
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  for (const FitnessPoint& point : plot.points)
    cairo_line_to(c, axes.x(point.generation), axes.y(point.*value));
  if (plot.points.size() == 1) {
    cairo_arc(c, axes.x(plot.points[0].generation), axes.y(plot.points[0].*value), 3, 0, 6.2831853);
  }
  cairo_stroke(c);
}

void draw_legend(cairo_t* c, double x, const std::string& words, Colour colour) {
  use(c, colour);
  cairo_rectangle(c, x, 25, 18, 4);
  cairo_fill(c);
  use(c, kInk);
  text(c, x + 24, 32, words, 14, 0);
}

void draw(cairo_t* c, const FitnessPlot& plot) {
  cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_source_rgb(c, 1, 1, 1);
  cairo_paint(c);
  double largest = 0;
  for (const FitnessPoint& point : plot.points) largest = std::max(largest, point.best);
  const double last = plot.points.empty() ? 1 : std::max<double>(1, plot.points.back().generation);
  const Axes axes{last, axis_end(largest)};
  use(c, kInk);
  text(c, kLeft, 32, plot.title, 17, 0);
  draw_legend(c, kWidth - 230, "best", kBest);
  draw_legend(c, kWidth - 130, "mean", kMean);
  draw_axes(c, axes);
  draw_curve(c, axes, plot, &FitnessPoint::mean, kMean);
  draw_curve(c, axes, plot, &FitnessPoint::best, kBest);
}

cairo_status_t append(void* out, const unsigned char* data, unsigned length) {
  static_cast<std::string*>(out)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

Status checked(cairo_status_t status, const std::string& what) {
  if (status == CAIRO_STATUS_SUCCESS) return {};
  return fail(ErrorCode::kIo, what + ": " + cairo_status_to_string(status));
}

}  // namespace

double axis_end(double largest) {
  if (!(largest > 1)) return 1;
  double power = 1;
  while (power * 10 < largest) power *= 10;
  for (const double step : {1.0, 2.0, 2.5, 5.0}) {
    if (step * power >= largest) return step * power;
  }
  return 10 * power;
}

Status write_png(const FitnessPlot& plot, const std::filesystem::path& path) {
  const Surface surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(kWidth), static_cast<int>(kHeight)),
      cairo_surface_destroy);
  const Context context(cairo_create(surface.get()), cairo_destroy);
  draw(context.get(), plot);
  return checked(cairo_surface_write_to_png(surface.get(), path.c_str()), path.string());
}

Result<std::string> to_svg(const FitnessPlot& plot) {
  std::string svg;
  {
    const Surface surface(cairo_svg_surface_create_for_stream(append, &svg, kWidth, kHeight),
                          cairo_surface_destroy);
    const Context context(cairo_create(surface.get()), cairo_destroy);
    draw(context.get(), plot);
    cairo_surface_finish(surface.get());
    if (auto status = checked(cairo_surface_status(surface.get()), "SVG"); !status)
      return tl::unexpected(status.error());
  }
  const std::size_t start = svg.find("<svg");
  return start == std::string::npos ? svg : svg.substr(start);
}

}  // namespace evograsp::cli

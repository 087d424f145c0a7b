#include "cli/chart_pen.h"

#include <iterator>

namespace evograsp::cli {
namespace {

// Okabe and Ito, "Color universal design" (2008), without the yellow, which is faint on white.
constexpr Colour kSeries[] = {
    {0.000, 0.447, 0.698},  // blue
    {0.835, 0.369, 0.000},  // vermilion
    {0.000, 0.620, 0.451},  // bluish green
    {0.800, 0.475, 0.655},  // reddish purple
    {0.902, 0.624, 0.000},  // orange
    {0.337, 0.706, 0.914},  // sky blue
    {0.250, 0.250, 0.250},  // grey
    {0.550, 0.340, 0.130},  // brown
};
constexpr double kTurn = 6.283185307179586;

}  // namespace

Colour series_colour(int index) {
  return kSeries[static_cast<std::size_t>(index) % std::size(kSeries)];
}

void use_dashes(cairo_t* c, int index) {
  static constexpr double kPatterns[][4] = {{7, 3, 7, 3}, {2.5, 2.5, 2.5, 2.5}, {9, 3, 2, 3}};
  // Three neighbours in colour are whole: dashes only help where colours get many.
  if (index % 8 < 3) return cairo_set_dash(c, nullptr, 0, 0);
  cairo_set_dash(c, kPatterns[static_cast<std::size_t>(index) % std::size(kPatterns)], 4, 0);
}

Pen::Pen(cairo_t* context) : c_(context) {
  cairo_set_line_join(c_, CAIRO_LINE_JOIN_ROUND);
}

void Pen::use(Colour colour, double alpha) {
  cairo_set_source_rgba(c_, colour.r, colour.g, colour.b, alpha);
}

void Pen::line(double x1, double y1, double x2, double y2, double width) {
  cairo_set_line_width(c_, width);
  cairo_move_to(c_, x1, y1);
  cairo_line_to(c_, x2, y2);
  cairo_stroke(c_);
}

void Pen::rectangle(double x, double y, double width, double height) {
  cairo_rectangle(c_, x, y, width, height);
  cairo_fill(c_);
}

void Pen::dot(double x, double y, double radius) {
  cairo_arc(c_, x, y, radius, 0, kTurn);
  cairo_fill(c_);
}

void Pen::diamond(double x, double y, double radius) {
  cairo_move_to(c_, x, y - radius);
  cairo_line_to(c_, x + radius, y);
  cairo_line_to(c_, x, y + radius);
  cairo_line_to(c_, x - radius, y);
  cairo_close_path(c_);
  use({1, 1, 1});
  cairo_set_line_width(c_, 2.5);
  cairo_stroke_preserve(c_);
  use({0, 0, 0});
  cairo_fill(c_);
}

void Pen::set_font(double size, bool bold) {
  cairo_select_font_face(c_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(c_, size);
}

double Pen::text_width(const std::string& words, double size, bool bold) {
  set_font(size, bold);
  cairo_text_extents_t extents;
  cairo_text_extents(c_, words.c_str(), &extents);
  return extents.x_advance;
}

void Pen::text(double x, double y, const std::string& words, double size, TextAlign align, bool bold) {
  const double width = text_width(words, size, bold);
  const double part = align == TextAlign::kLeft ? 0 : align == TextAlign::kCentre ? 0.5 : 1;
  cairo_move_to(c_, x - part * width, y);
  cairo_show_text(c_, words.c_str());
  cairo_new_path(c_);  // or the pen's place after the last letter begins the next line
}

void Pen::turned_text(double x, double y, const std::string& words, double size, double angle,
                      TextAlign align) {
  cairo_save(c_);
  cairo_translate(c_, x, y);
  cairo_rotate(c_, angle);
  text(0, 0, words, size, align);
  cairo_restore(c_);
}

}  // namespace evograsp::cli

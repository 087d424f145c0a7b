// What charts are drawn with: Cairo, in words of this program.
#pragma once

#include <cairo.h>

#include <string>

namespace evograsp::cli {

struct Colour {
  double r, g, b;
};
inline constexpr Colour kInk{0.13, 0.15, 0.18}, kPaleInk{0.38, 0.41, 0.46}, kGrid{0.89, 0.90, 0.92};

// By index: the first eight differ, then they come again.
Colour series_colour(int index);
// Dashes of a line by index: the first whole, then ever other patterns.
void use_dashes(cairo_t* c, int index);

enum class TextAlign { kLeft, kCentre, kRight };

// Borrows the context. Not thread-safe.
class Pen {
 public:
  explicit Pen(cairo_t* context);

  cairo_t* context() const { return c_; }
  void use(Colour colour, double alpha = 1);
  void line(double x1, double y1, double x2, double y2, double width);
  void rectangle(double x, double y, double width, double height);  // filled
  void dot(double x, double y, double radius);                      // filled
  // Black with a white rim, so that it shows on every colour.
  void diamond(double x, double y, double radius);
  double text_width(const std::string& words, double size, bool bold = false);
  // y: the line that letters stand on.
  void text(double x, double y, const std::string& words, double size, TextAlign align = TextAlign::kLeft,
            bool bold = false);
  // Turned about its point; radians, clockwise.
  void turned_text(double x, double y, const std::string& words, double size, double angle, TextAlign align);

 private:
  void set_font(double size, bool bold);
  cairo_t* c_;
};

}  // namespace evograsp::cli

#include "sim/render_overlay.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>

namespace evograsp::sim {

struct Overlay::Canvas {
  cairo_surface_t* surface;
  cairo_t* cairo;
  int width, height;
  // Line widths and letters for a picture of 480 rows, scaled to others.
  double unit() const { return std::max(1.0, height / 480.0); }
};

Overlay::Overlay(const ColourImage& image) : canvas_(new Canvas) {
  canvas_->surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height);
  canvas_->width = image.width, canvas_->height = image.height;
  cairo_surface_flush(canvas_->surface);
  unsigned char* data = cairo_image_surface_get_data(canvas_->surface);
  const std::size_t stride = static_cast<std::size_t>(cairo_image_surface_get_stride(canvas_->surface));
  for (int v = 0; data != nullptr && v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const std::uint8_t* rgb =
          &image.rgb[3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                          static_cast<std::size_t>(u))];
      unsigned char* pixel = data + static_cast<std::size_t>(v) * stride + 4 * static_cast<std::size_t>(u);
      pixel[0] = rgb[2], pixel[1] = rgb[1], pixel[2] = rgb[0], pixel[3] = 255;
    }
  cairo_surface_mark_dirty(canvas_->surface);
  canvas_->cairo = cairo_create(canvas_->surface);
  cairo_translate(canvas_->cairo, 0.5, 0.5);
}

Overlay::~Overlay() {
  cairo_destroy(canvas_->cairo);
  cairo_surface_destroy(canvas_->surface);
  delete canvas_;
}

namespace {

// A light line on a dark one: seen on any ground.
void stroke_twice(cairo_t* cairo, double width) {
  cairo_set_source_rgba(cairo, 0.05, 0.07, 0.10, 0.65);
  cairo_set_line_width(cairo, 2.2 * width);
  cairo_stroke_preserve(cairo);
  cairo_set_source_rgb(cairo, 1.0, 0.80, 0.16);
  cairo_set_line_width(cairo, width);
  cairo_stroke(cairo);
}

}  // namespace

void Overlay::rectangle(const ImageBox& box) {
  cairo_rectangle(canvas_->cairo, box.left, box.top, box.width(), box.height());
  stroke_twice(canvas_->cairo, 1.6 * canvas_->unit());
}

void Overlay::cross(const Pixel& at) {
  const double near = 3 * canvas_->unit(), far = 9 * canvas_->unit();
  for (const auto& [x, y] : {std::pair{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}}) {
    cairo_move_to(canvas_->cairo, at.u + x * near, at.v + y * near);
    cairo_line_to(canvas_->cairo, at.u + x * far, at.v + y * far);
  }
  stroke_twice(canvas_->cairo, 1.6 * canvas_->unit());
}

void Overlay::caption(const std::string& text) {
  cairo_t* cairo = canvas_->cairo;
  const double unit = canvas_->unit(), size = 13 * unit, pad = 7 * unit;
  cairo_select_font_face(cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, text.c_str(), &extents);
  const double left = 12 * unit, bottom = canvas_->height - 12 * unit;
  const double width = extents.x_advance + 2 * pad, height = size + 1.4 * pad, radius = 5 * unit;
  constexpr double kQuarter = 1.5707963267948966;
  const double top = bottom - height, right = left + width;
  cairo_new_sub_path(cairo);
  cairo_arc(cairo, right - radius, top + radius, radius, -kQuarter, 0);
  cairo_arc(cairo, right - radius, bottom - radius, radius, 0, kQuarter);
  cairo_arc(cairo, left + radius, bottom - radius, radius, kQuarter, 2 * kQuarter);
  cairo_arc(cairo, left + radius, top + radius, radius, 2 * kQuarter, 3 * kQuarter);
  cairo_close_path(cairo);
  cairo_set_source_rgba(cairo, 1, 1, 1, 0.82);
  cairo_fill(cairo);
  cairo_set_source_rgb(cairo, 0.13, 0.15, 0.18);
  cairo_move_to(cairo, left + pad, bottom - 0.95 * pad);
  cairo_show_text(cairo, text.c_str());
}

ColourImage Overlay::finish() const {
  ColourImage image(canvas_->width, canvas_->height);
  cairo_surface_flush(canvas_->surface);
  const unsigned char* data = cairo_image_surface_get_data(canvas_->surface);
  const std::size_t stride = static_cast<std::size_t>(cairo_image_surface_get_stride(canvas_->surface));
  for (int v = 0; data != nullptr && v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const unsigned char* pixel =
          data + static_cast<std::size_t>(v) * stride + 4 * static_cast<std::size_t>(u);
      std::uint8_t* rgb = image.pixel(u, v);
      rgb[0] = pixel[2], rgb[1] = pixel[1], rgb[2] = pixel[0];
    }
  return image;
}

ColourImage colour_depth(std::span<const float> depth, int columns, int rows, int cell) {
  // Near to far; dark ends keep their order in grey.
  static constexpr double kStops[][3] = {{0.99, 0.91, 0.55}, {0.98, 0.64, 0.30}, {0.87, 0.34, 0.33},
                                         {0.60, 0.17, 0.43}, {0.31, 0.09, 0.44}, {0.06, 0.04, 0.20}};
  constexpr int kSteps = 5;
  // The scale is stretched over what is there: a window spans a small part of [near, far].
  float low = 1, high = 0;
  for (const float z : depth)
    if (z < 1) low = std::min(low, z), high = std::max(high, z);
  const double span = high > low ? high - low : 1;
  ColourImage image(columns * cell, rows * cell);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const float z = depth[static_cast<std::size_t>(v / cell) * static_cast<std::size_t>(columns) +
                            static_cast<std::size_t>(u / cell)];
      std::uint8_t* rgb = image.pixel(u, v);
      if (!(z < 1)) {
        rgb[0] = rgb[1] = rgb[2] = 110;
        continue;
      }
      const double at = kSteps * std::clamp((z - low) / span, 0.0, 1.0);
      const int step = std::min(kSteps - 1, static_cast<int>(at));
      for (int k = 0; k < 3; ++k)
        rgb[k] = static_cast<std::uint8_t>(
            std::lround(255 * (kStops[step][k] + (at - step) * (kStops[step + 1][k] - kStops[step][k]))));
    }
  return image;
}

ColourImage beside(const ColourImage& left, const ColourImage& right, int gap) {
  ColourImage out(left.width + gap + right.width, std::max(left.height, right.height));
  std::fill(out.rgb.begin(), out.rgb.end(), std::uint8_t{255});
  const auto paste = [&](const ColourImage& image, int at) {
    const int top = (out.height - image.height) / 2;
    for (int v = 0; v < image.height; ++v)
      std::copy_n(&image.rgb[3 * static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width)],
                  3 * static_cast<std::size_t>(image.width), out.pixel(at, top + v));
  };
  paste(left, 0);
  paste(right, left.width + gap);
  return out;
}

}  // namespace evograsp::sim

#include "cli/chart_surface.h"

#include <cairo-svg.h>

#include <cmath>
#include <memory>
#include <new>

#include "cli/inputs.h"

namespace evograsp::cli {
namespace {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

// Called by C: nothing may be thrown through it.
cairo_status_t append(void* out, const unsigned char* data, unsigned length) try {
  static_cast<std::string*>(out)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
} catch (const std::bad_alloc&) {
  return CAIRO_STATUS_NO_MEMORY;
}

Status checked(cairo_status_t status, const std::string& what) {
  if (status == CAIRO_STATUS_SUCCESS) return {};
  return fail(ErrorCode::kIo, what + ": " + cairo_status_to_string(status));
}

}  // namespace

Status draw_png(CanvasSize size, const std::filesystem::path& path, const std::function<void(Pen&)>& draw) {
  const Surface surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(std::ceil(size.width)),
                                 static_cast<int>(std::ceil(size.height))),
      cairo_surface_destroy);
  const Context context(cairo_create(surface.get()), cairo_destroy);
  Pen pen(context.get());
  draw(pen);
  std::string png;
  if (auto status = checked(cairo_surface_write_to_png_stream(surface.get(), append, &png), path.string());
      !status)
    return status;
  return write_file(path, png);
}

Result<std::string> draw_svg(CanvasSize size, const std::function<void(Pen&)>& draw) {
  std::string svg;
  {
    const Surface surface(cairo_svg_surface_create_for_stream(append, &svg, size.width, size.height),
                          cairo_surface_destroy);
    const Context context(cairo_create(surface.get()), cairo_destroy);
    Pen pen(context.get());
    draw(pen);
    cairo_surface_finish(surface.get());
    if (auto status = checked(cairo_surface_status(surface.get()), "SVG"); !status)
      return tl::unexpected(status.error());
  }
  const std::size_t start = svg.find("<svg");
  return start == std::string::npos ? svg : svg.substr(start);
}

}  // namespace evograsp::cli

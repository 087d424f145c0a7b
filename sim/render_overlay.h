// Lines, marks and words on pictures, drawn with cairo; and what the network sees, as a picture.
#pragma once

#include <span>
#include <string>

#include "sim/camera.h"
#include "sim/image_bounds.h"
#include "sim/png.h"

namespace evograsp::sim {

// Draws on a picture; finish() gives it back. Coordinates are pixels with centres at integers, as a camera's.
class Overlay {
 public:
  explicit Overlay(const ColourImage& image);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  void rectangle(const ImageBox& box);
  void cross(const Pixel& at);
  // In the lower left corner, on a pale strip.
  void caption(const std::string& text);
  ColourImage finish() const;

 private:
  struct Canvas;
  Canvas* canvas_;
};

// Depth samples in [0, 1] as a picture of columns x rows cells of `cell` pixels: near is bright and warm, far
// is dark and blue, no return is grey.
ColourImage colour_depth(std::span<const float> depth, int columns, int rows, int cell);

// Two pictures side by side on white, a gap between them; the lower one is centred.
ColourImage beside(const ColourImage& left, const ColourImage& right, int gap);

}  // namespace evograsp::sim

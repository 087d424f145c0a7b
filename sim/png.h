// Pictures in and out: PNG by libpng, PGM by hand. Input is untrusted and bounded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace evograsp::sim {

// 8 bits a channel, row by row from the top left, red first.
struct ColourImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  ColourImage() = default;
  ColourImage(int w, int h)
      : width(w), height(h), rgb(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 3) {}
  std::uint8_t* pixel(int u, int v) {
    return &rgb[3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(u))];
  }
};

// 16 bits of grey, row by row from the top left.
struct GreyImage {
  int width = 0, height = 0;
  std::vector<std::uint16_t> value;
};

inline constexpr int kMaxImageSide = 8192;
inline constexpr std::uint64_t kMaxImagePixels = 1u << 25;
inline constexpr std::uint64_t kMaxImageFileBytes = 1u << 27;

// The bytes of a PNG file; the same image gives the same bytes with the same zlib. Thread-safe, all of them.
Result<std::string> encode_png(const ColourImage& image);
Result<std::string> encode_png(const GreyImage& image);

// A 16-bit grey image, PNG or binary PGM (P5, maximum above 255) by its first bytes. `name` begins every
// error. Errors (kInvalid): neither format, another depth or colour type, sizes beyond the limits above,
// truncated or damaged data. Memory stays within a few times the stated size of the image, which is checked
// before any is taken.
Result<GreyImage> decode_grey16(std::string_view bytes, const std::string& name);

Result<GreyImage> read_grey16(const std::filesystem::path& file);
// Errors (kIo): cannot be opened or written in full.
Status write_picture(const std::filesystem::path& file, const std::string& bytes);

}  // namespace evograsp::sim

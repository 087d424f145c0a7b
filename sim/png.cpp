#include "sim/png.h"

#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>

namespace evograsp::sim {
namespace {

// libpng reports errors by longjmp, which skips destructors. So every call into it happens in run_guarded(),
// whose steps own nothing: what they need stands in a Session made before and destroyed after.
struct Session {
  png_structp png = nullptr;
  png_infop info = nullptr;
  bool writing = false;
  std::string_view input;
  std::size_t position = 0;
  std::string output;
  png_uint_32 width = 0, height = 0;
  int bit_depth = 0, colour_type = 0;
  png_bytep pixels = nullptr;
  char message[160] = "";

  ~Session() {
    if (writing) {
      png_destroy_write_struct(&png, &info);
    } else {
      png_destroy_read_struct(&png, &info, nullptr);
    }
  }
  std::size_t row_bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(bit_depth / 8) *
           (colour_type == PNG_COLOR_TYPE_RGB ? 3u : 1u);
  }
};

void on_error(png_structp png, png_const_charp text) {
  auto* session = static_cast<Session*>(png_get_error_ptr(png));
  std::snprintf(session->message, sizeof session->message, "%s", text);
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep to, png_size_t count) {
  auto* session = static_cast<Session*>(png_get_io_ptr(png));
  if (count > session->input.size() - session->position) png_error(png, "the file ends too early");
  std::memcpy(to, session->input.data() + session->position, count);
  session->position += count;
}

void on_write(png_structp png, png_bytep from, png_size_t count) {
  static_cast<Session*>(png_get_io_ptr(png))->output.append(reinterpret_cast<const char*>(from), count);
}
void on_flush(png_structp) {}

using Step = void (*)(Session*);
bool run_guarded(Session* session, Step step) {
  if (setjmp(png_jmpbuf(session->png)) != 0) return false;
  step(session);
  return true;
}

void read_header(Session* s) {
  png_set_read_fn(s->png, s, on_read);
  png_set_user_limits(s->png, kMaxImageSide, kMaxImageSide);
  png_set_chunk_malloc_max(s->png, 1u << 20);
  png_set_chunk_cache_max(s->png, 64);
  png_read_info(s->png, s->info);
  png_get_IHDR(s->png, s->info, &s->width, &s->height, &s->bit_depth, &s->colour_type, nullptr, nullptr,
               nullptr);
}

void read_pixels(Session* s) {
  png_set_swap(s->png);  // big-endian in the file
  const int passes = png_set_interlace_handling(s->png);
  png_read_update_info(s->png, s->info);
  for (int pass = 0; pass < passes; ++pass)
    for (png_uint_32 row = 0; row < s->height; ++row)
      png_read_row(s->png, s->pixels + row * s->row_bytes(), nullptr);
  png_read_end(s->png, nullptr);
}

void write_all(Session* s) {
  png_set_write_fn(s->png, s, on_write, on_flush);
  png_set_IHDR(s->png, s->info, s->width, s->height, s->bit_depth, s->colour_type, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(s->png, s->info);
  if (s->bit_depth == 16) png_set_swap(s->png);
  for (png_uint_32 row = 0; row < s->height; ++row) png_write_row(s->png, s->pixels + row * s->row_bytes());
  png_write_end(s->png, nullptr);
}

tl::unexpected<Error> bad(const std::string& name, const std::string& why) {
  return fail(ErrorCode::kInvalid, name + ": " + why);
}

// Why an image of this size is refused; empty when it is fine.
std::string size_complaint(std::uint64_t width, std::uint64_t height) {
  if (width >= 1 && height >= 1 && width <= kMaxImageSide && height <= kMaxImageSide &&
      width * height <= kMaxImagePixels)
    return {};
  return "the image has " + std::to_string(width) + " x " + std::to_string(height) + " pixels; 1 to " +
         std::to_string(kMaxImageSide) + " a side and at most " + std::to_string(kMaxImagePixels) +
         " are allowed";
}

Result<GreyImage> decode_png(std::string_view bytes, const std::string& name) {
  const auto session = std::make_unique<Session>();
  session->input = bytes;
  session->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, session.get(), on_error, on_warning);
  if (session->png) session->info = png_create_info_struct(session->png);
  if (!session->info) return fail(ErrorCode::kInternal, name + ": libpng cannot start");
  if (!run_guarded(session.get(), read_header))
    return bad(name, std::string("not a readable PNG: ") + session->message);
  if (const std::string why = size_complaint(session->width, session->height); !why.empty())
    return bad(name, why);
  if (session->bit_depth != 16 || session->colour_type != PNG_COLOR_TYPE_GRAY)
    return bad(name, "a depth image must be 16-bit grey; this PNG has " + std::to_string(session->bit_depth) +
                         " bits a channel" +
                         (session->colour_type == PNG_COLOR_TYPE_GRAY ? "" : " and colour"));
  // Data compresses a thousandfold at most: a header that promises more has no pixels behind it.
  if (session->row_bytes() * session->height > bytes.size() * 1100 + 4096)
    return bad(name, "the file is too short for the image it announces");
  GreyImage image{static_cast<int>(session->width), static_cast<int>(session->height), {}};
  image.value.resize(static_cast<std::size_t>(session->width) * session->height);
  session->pixels = reinterpret_cast<png_bytep>(image.value.data());
  if (!run_guarded(session.get(), read_pixels))
    return bad(name, std::string("damaged PNG: ") + session->message);
  return image;
}

// Reads the numbers of a PNM header; comments run from # to the end of the line.
class PgmHeader {
 public:
  explicit PgmHeader(std::string_view bytes) : bytes_(bytes) {}
  // A decimal number of at most six digits, or -1.
  int number() {
    for (; at_ < bytes_.size(); ++at_) {
      if (bytes_[at_] == '#') {
        while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
      } else if (!is_space(bytes_[at_])) {
        break;
      }
    }
    int value = 0, digits = 0;
    for (; at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9' && digits < 7; ++at_, ++digits)
      value = value * 10 + (bytes_[at_] - '0');
    return digits == 0 || digits > 6 ? -1 : value;
  }
  // The byte after the header, or npos when no single white space ends it.
  std::size_t data() const {
    return at_ < bytes_.size() && is_space(bytes_[at_]) ? at_ + 1 : std::string_view::npos;
  }
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 2;
};

Result<GreyImage> decode_pgm(std::string_view bytes, const std::string& name) {
  PgmHeader header(bytes);
  const int width = header.number();
  const int height = header.number();
  const int maximum = header.number();
  const std::size_t data = header.data();
  if (width < 0 || height < 0 || maximum < 1 || maximum > 65535 || data == std::string_view::npos)
    return bad(name, "the PGM header is not 'P5 WIDTH HEIGHT MAXIMUM'");
  if (const std::string why =
          size_complaint(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height));
      !why.empty())
    return bad(name, why);
  if (maximum < 256)
    return bad(name,
               "a depth image must have 16 bits; this PGM has 8 (maximum " + std::to_string(maximum) + ")");
  GreyImage image{width, height, {}};
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (bytes.size() - data < 2 * count)
    return bad(name, "the PGM ends after " + std::to_string((bytes.size() - data) / 2) + " of " +
                         std::to_string(count) + " pixels");
  image.value.resize(count);
  const auto* byte = reinterpret_cast<const unsigned char*>(bytes.data() + data);
  for (std::size_t i = 0; i < count; ++i)
    image.value[i] = static_cast<std::uint16_t>(byte[2 * i] << 8 | byte[2 * i + 1]);
  return image;
}

Result<std::string> encode(int width, int height, int bit_depth, int colour_type, const void* pixels) {
  const auto session = std::make_unique<Session>();
  session->writing = true;
  session->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, session.get(), on_error, on_warning);
  if (session->png) session->info = png_create_info_struct(session->png);
  if (!session->info) return fail(ErrorCode::kInternal, "libpng cannot start");
  session->width = static_cast<png_uint_32>(width), session->height = static_cast<png_uint_32>(height);
  session->bit_depth = bit_depth, session->colour_type = colour_type;
  session->pixels = static_cast<png_bytep>(const_cast<void*>(pixels));
  if (!run_guarded(session.get(), write_all))
    return fail(ErrorCode::kInternal, std::string("PNG: ") + session->message);
  return std::move(session->output);
}

}  // namespace

Result<std::string> encode_png(const ColourImage& image) {
  return encode(image.width, image.height, 8, PNG_COLOR_TYPE_RGB, image.rgb.data());
}

Result<std::string> encode_png(const GreyImage& image) {
  return encode(image.width, image.height, 16, PNG_COLOR_TYPE_GRAY, image.value.data());
}

Result<GreyImage> decode_grey16(std::string_view bytes, const std::string& name) {
  if (bytes.size() >= 8 && png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, 8) == 0)
    return decode_png(bytes, name);
  if (bytes.size() >= 3 && bytes.substr(0, 2) == "P5" && (PgmHeader::is_space(bytes[2]) || bytes[2] == '#'))
    return decode_pgm(bytes, name);
  return bad(name, bytes.empty() ? "the file is empty" : "neither a PNG nor a binary PGM (P5)");
}

Result<GreyImage> read_grey16(const std::filesystem::path& file) {
  std::error_code error;
  const std::string name = file.string();
  if (!std::filesystem::exists(file, error))
    return fail(ErrorCode::kNotFound, name + ": there is no such file");
  if (!std::filesystem::is_regular_file(file, error)) return bad(name, "not a regular file");
  const std::uint64_t size = std::filesystem::file_size(file, error);
  if (error) return fail(ErrorCode::kIo, name + ": " + error.message());
  if (size > kMaxImageFileBytes)
    return bad(name, "the file has " + std::to_string(size) + " bytes; at most " +
                         std::to_string(kMaxImageFileBytes) + " are read");
  std::string bytes(size, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size)))
    return fail(ErrorCode::kIo, name + ": cannot be read");
  return decode_grey16(bytes, name);
}

Status write_picture(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) return fail(ErrorCode::kIo, file.string() + ": cannot be written");
  return {};
}

}  // namespace evograsp::sim

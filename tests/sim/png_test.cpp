// Depth images come from strangers: every damage is a clear error, never a crash or a large allocation.
#include "sim/png.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/random.h"

namespace evograsp::sim {
namespace {

using ::testing::HasSubstr;

GreyImage gradient(int width, int height) {
  GreyImage image{width, height, {}};
  for (int i = 0; i < width * height; ++i) image.value.push_back(static_cast<std::uint16_t>(i * 257 + 3));
  return image;
}

std::string pgm(const GreyImage& image, const std::string& header) {
  std::string bytes = header;
  for (const std::uint16_t v : image.value)
    bytes += static_cast<char>(v >> 8), bytes += static_cast<char>(v & 255);
  return bytes;
}

std::string big_endian(std::uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
          static_cast<char>(v)};
}

std::uint32_t crc32_of(const std::string& bytes) {
  std::uint32_t crc = ~0u;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int k = 0; k < 8; ++k) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  return ~crc;
}

// A PNG that announces an image of this size and kind and ends where its pixels should come.
std::string header_only(std::uint32_t width, std::uint32_t height, int bits, int colour_type) {
  std::string chunk = "IHDR" + big_endian(width) + big_endian(height);
  chunk += static_cast<char>(bits), chunk += static_cast<char>(colour_type), chunk += std::string(3, '\0');
  return std::string("\x89PNG\r\n\x1a\n", 8) + big_endian(13) + chunk + big_endian(crc32_of(chunk)) +
         big_endian(100) + "IDAT";
}

std::string complaint(const std::string& bytes) {
  const Result<GreyImage> image = decode_grey16(bytes, "frame");
  EXPECT_FALSE(image);
  if (image) return {};
  EXPECT_EQ(image.error().code, ErrorCode::kInvalid);
  EXPECT_EQ(image.error().message.rfind("frame: ", 0), 0u) << image.error().message;
  return image.error().message;
}

TEST(Png, GreyComesBackAsItWent) {
  const GreyImage image = gradient(37, 21);
  const Result<GreyImage> back = decode_grey16(*encode_png(image), "frame");
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->width, 37);
  EXPECT_EQ(back->height, 21);
  EXPECT_EQ(back->value, image.value);
}

TEST(Png, PgmIsReadWithComments) {
  const GreyImage image = gradient(5, 4);
  for (const char* header :
       {"P5 5 4 65535\n", "P5\n# made by hand\n5 # columns\n4\n65535\n", "P5\n5 4\n256\n"}) {
    const Result<GreyImage> back = decode_grey16(pgm(image, header), "frame");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->value, image.value);
  }
}

TEST(Png, OtherKindsAreRefusedByName) {
  EXPECT_THAT(complaint(""), HasSubstr("empty"));
  EXPECT_THAT(complaint("GIF89a rest of the file"), HasSubstr("neither a PNG nor"));
  EXPECT_THAT(complaint(*encode_png(ColourImage(4, 4))), HasSubstr("16-bit grey"));
  EXPECT_THAT(complaint(header_only(4, 4, 8, 0)), HasSubstr("8 bits"));
  EXPECT_THAT(complaint(pgm(gradient(4, 4), "P5 4 4 255\n")), HasSubstr("16 bits"));
  EXPECT_THAT(complaint("P2 4 4 65535\n1 2 3"), HasSubstr("neither"));
}

TEST(Png, TruncatedFilesAreRefusedAtEveryLength) {
  const std::string whole = *encode_png(gradient(64, 48));
  for (std::size_t n = 0; n < whole.size(); n += 7) complaint(whole.substr(0, n));
  const std::string grey = pgm(gradient(6, 5), "P5 6 5 65535\n");
  for (std::size_t n = 0; n < grey.size(); ++n) complaint(grey.substr(0, n));
}

TEST(Png, BombsAreRefusedBeforeMemoryIsTaken) {
  EXPECT_THAT(complaint(header_only(8193, 10, 16, 0)), HasSubstr("frame"));
  EXPECT_THAT(complaint(header_only(8192, 8192, 16, 0)), HasSubstr("are allowed"));
  EXPECT_THAT(complaint(header_only(4096, 4096, 16, 0)), HasSubstr("too short"));
  EXPECT_THAT(complaint(header_only(0, 4, 16, 0)), HasSubstr("PNG"));
  EXPECT_THAT(complaint("P5 999999 999999 65535\nx"), HasSubstr("are allowed"));
  EXPECT_THAT(complaint("P5 4000 4000 65535\nx"), HasSubstr("ends after 0 of"));
  EXPECT_THAT(complaint("P5 99999999999 1 65535\nx"), HasSubstr("header"));
  EXPECT_THAT(complaint("P5 -4 4 65535\nx"), HasSubstr("header"));
}

TEST(Png, FlippedBytesNeverCrash) {
  const std::string whole = *encode_png(gradient(40, 30));
  Random random(9, Purpose::kTestHarness);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string bytes = whole;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t at = random.below(static_cast<std::uint32_t>(bytes.size()));
      bytes[at] = static_cast<char>(random.next());
    }
    refused += !decode_grey16(bytes, "frame");
  }
  EXPECT_GT(refused, 2900) << "checksums catch nearly all";
}

TEST(Png, MissingFilesAndFoldersAreErrors) {
  EXPECT_EQ(read_grey16("/nowhere/depth.png").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_grey16("/tmp").error().code, ErrorCode::kInvalid);
  EXPECT_EQ(write_picture("/nowhere/out.png", "x").error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace evograsp::sim

// Camera files of recorded depth images.
#include "cli/camera_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace evograsp::cli {
namespace {

class CameraFile : public ::testing::Test {
 protected:
  CameraFile()
      : file_((std::filesystem::temp_directory_path() / ("evograsp_camera_" + std::to_string(::getpid())))
                  .string()) {}
  ~CameraFile() override { std::filesystem::remove(file_); }

  Result<sim::ImageCamera> read(const std::string& members) {
    std::ofstream(file_) << R"({"fx": 20.5, "fy": 20, "cx": 12, "cy": 9)" << members << "}";
    return read_camera(file_, sim::GreyImage{24, 18, std::vector<std::uint16_t>(24 * 18, 1000)});
  }
  const std::string file_;
};

TEST_F(CameraFile, GivesWhatItSaysAndDefaultsElse) {
  const auto plain = read("");
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(plain->fx, 20.5);
  EXPECT_EQ(plain->units_per_metre, 1000);
  EXPECT_FALSE(plain->registered_kinect);
  const auto full = read(R"(, "units_per_metre": 5000, "invalid": 65535, "width": 24, "height": 18)");
  ASSERT_TRUE(full) << full.error().message;
  EXPECT_EQ(full->units_per_metre, 5000);
  EXPECT_EQ(full->invalid, 65535);
}

TEST_F(CameraFile, RefusesByNameWhatNoCameraIs) {
  for (const char* members :
       {R"(, "invalid": 0.5)", R"(, "invalid": 65536)", R"(, "invalid": "0")", R"(, "units_per_metre": 0)",
        R"(, "units_per_metre": -1)", R"(, "units_per_metre": 1e7)", R"(, "width": 25)", R"(, "fx": 21)",
        R"(, "unit_per_metre": 1)", R"(, "note": "no units")"}) {
    const auto camera = read(members);
    ASSERT_FALSE(camera) << members;
    EXPECT_EQ(camera.error().code, ErrorCode::kInvalid) << members;
    EXPECT_TRUE(camera.error().message.starts_with(file_ + ": ")) << camera.error().message;
  }
}

}  // namespace
}  // namespace evograsp::cli

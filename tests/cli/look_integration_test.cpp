// sim, render and infer: the real binary.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/scene_flags.h"
#include "proto/genome.pb.h"
#include "sim/camera.h"
#include "sim/png.h"
#include "tests/data_folder.h"

namespace evograsp::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

struct Ran {
  int code = -1;
  std::string out;  // both streams
};

class Look : public ::testing::Test {
 protected:
  Look() : folder_(fs::temp_directory_path() / ("evograsp_look_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~Look() override { fs::remove_all(folder_); }

  Ran run(const std::string& arguments) {
    Ran ran;
    const std::string command = std::string(EVOGRASP_BIN_DIR) + "/evograsp " + arguments + " 2>&1";
    std::FILE* pipe = ::popen(command.c_str(), "r");
    std::array<char, 4096> buffer;
    for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
      ran.out.append(buffer.data(), n);
    const int status = ::pclose(pipe);
    ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return ran;
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  // A champion whose network answers the same pose to everything: the given outputs.
  void write_champion(const std::string& name, const std::vector<float>& outputs,
                      const proto::TrialsConfig& trials = {}) const {
    proto::Champion champion;
    champion.mutable_experiment()->mutable_scene()->add_object("cube");
    champion.mutable_experiment()->mutable_camera();
    champion.mutable_experiment()->mutable_grasp();
    *champion.mutable_experiment()->mutable_trials() = trials;
    champion.mutable_experiment()->mutable_fitness();
    proto::Network& network = *champion.mutable_network();
    network.set_inputs(304), network.set_outputs(7);
    for (std::uint32_t i = 0; i < 7; ++i) {
      network.add_activation(proto::LINEAR);
      network.add_bias(outputs[i]);
      network.add_first_link(0);
      network.add_output_node(305 + i);
    }
    network.add_first_link(0);
    write(name, champion.SerializeAsString());
  }

  fs::path folder_;
};

TEST_F(Look, SimGivesTheSameMeasurementsEveryTime) {
  const std::string call = "sim --seed 5 --object cube --pose '0.02 -0.05 0.08 0 1 0 0.5' --json";
  const Ran once = run(call);
  ASSERT_EQ(once.code, 0) << once.out;
  EXPECT_EQ(once.out, run(call).out);
  const json seen = json::parse(once.out);
  for (const char* key : {"outcome", "quality", "contacts", "asked", "reached", "target_centre",
                          "nearest_object", "target_distance", "theta"})
    EXPECT_TRUE(seen["measurement"].contains(key)) << key;
  EXPECT_EQ(seen["bounding_box"], true) << "as the schema's default";
  EXPECT_EQ(seen["measurement"]["asked"], json({0.02, -0.05, 0.08}));
  EXPECT_EQ(seen["joints"].size(), 12u);
  EXPECT_NE(run("sim --seed 6 --object cube --pose '0.02 -0.05 0.08 0 1 0 0.5' --json").out, once.out);
}

TEST_F(Look, AChampionActsAsThePoseItAnswers) {
  write_champion("zero.pb", {0, 0, 0, 0, 0, 0, 0});
  const Ran by_network = run("sim --seed 9 --champion " + path("zero.pb") + " --json");
  ASSERT_EQ(by_network.code, 0) << by_network.out;
  const json seen = json::parse(by_network.out);
  EXPECT_EQ(seen["pose"]["position"], seen["info"]["anchor"]) << "zero outputs land on the anchor";
  char pose[200];
  std::snprintf(pose, sizeof pose, "%.17g %.17g %.17g 0 0 1 0", seen["pose"]["position"][0].get<double>(),
                seen["pose"]["position"][1].get<double>(), seen["pose"]["position"][2].get<double>());
  const json by_pose =
      json::parse(run(std::string("sim --seed 9 --object cube --pose '") + pose + "' --json").out);
  EXPECT_EQ(by_pose["measurement"], seen["measurement"]);
}

TEST_F(Look, RenderWritesPicturesOfTheSizeAskedFor) {
  const Ran ran =
      run("render --object mug --seed 2 --pose '0 0 0.1 0 0 1 0' --samples 1 --size 64x48 --out " +
          path("scene.png") + " --json");
  ASSERT_EQ(ran.code, 0) << ran.out;
  EXPECT_TRUE(json::parse(ran.out).contains("measurement"));
  ASSERT_EQ(run("render --object mug --input --samples 1 --size 64x48 --out " + path("input.png")).code, 0);
  for (const char* name : {"scene.png", "input.png"}) {
    std::ifstream in(folder_ / name, std::ios::binary);
    std::string header(24, '\0');
    in.read(header.data(), 24);
    EXPECT_EQ(header.substr(1, 3), "PNG") << name;
    EXPECT_EQ(static_cast<unsigned char>(header[23]), 48) << name;
  }
}

// Simulated frame -> infer -> the pose the simulator itself would have commanded.
TEST_F(Look, InferOnASimulatedFrameFindsTheObject) {
  write_champion("zero.pb", {0, 0, 0, 0, 0, 0, 0});
  ASSERT_EQ(run("render --object cube --seed 4 --depth --out " + path("depth.png")).code, 0);
  write("camera.json",
        R"({"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "units_per_metre": 10000, "invalid": 0})");
  const json scene = json::parse(run("sim --object cube --seed 4 --json").out);
  const int u = static_cast<int>(scene["info"]["click"][0].get<double>() * 640);
  const int v = static_cast<int>(scene["info"]["click"][1].get<double>() * 480);
  const sim::Camera camera = *sim::Camera::create(proto::CameraConfig());
  const proto::Quat q = to_proto(camera.pose().rotation);
  char pose[300];
  std::snprintf(pose, sizeof pose, "%.17g %.17g %.17g %.17g %.17g %.17g %.17g", camera.eye().x(),
                camera.eye().y(), camera.eye().z(), q.w(), q.x(), q.y(), q.z());
  const Ran ran = run("infer " + path("zero.pb") + " --depth " + path("depth.png") + " --camera " +
                      path("camera.json") + " --click " + std::to_string(u) + "," + std::to_string(v) +
                      " --camera-pose '" + pose + "' --robot-pose '0.5 0 0 1 0 0 0' --json");
  ASSERT_EQ(ran.code, 0) << ran.out;
  const json answer = json::parse(ran.out);
  for (int k = 0; k < 3; ++k) {
    const double world = answer["world"]["tool"]["position"][k];
    EXPECT_NEAR(world, scene["info"]["anchor"][k].get<double>(), 0.012) << k;
    EXPECT_NEAR(answer["robot"]["tool"]["position"][k].get<double>(), world - (k == 0 ? 0.5 : 0), 1e-9) << k;
    EXPECT_NEAR(answer["world"]["clicked_point"][k].get<double>(), scene["info"]["point"][k].get<double>(),
                0.004)
        << k;
  }
  EXPECT_LT(answer["distance_from_click"].get<double>(), 0.07);
}

// A frame as the thesis's equations (6.1 to 6.3) have it: a wall 900 mm away, before it at 800 mm the front
// of a box of 60 x 60 mm. A pixel column is (z - 100) x 0.0021 x 640/480 mm wide there, a row (z - 100) x
// 0.0021 mm high.
TEST_F(Look, InferOnARegisteredKinectFrameUsesItsEquations) {
  write_champion("zero.pb", {0, 0, 0, 0, 0, 0, 0});
  constexpr int kWidth = 640, kHeight = 480;
  constexpr double kNear = 800, kColumn = (kNear - 100) * 0.0021 * 640 / 480, kRow = (kNear - 100) * 0.0021;
  const double centre_x = 100, centre_y = -40;  // mm, to the right of the optical axis and above it
  std::string pgm = "P5 640 480 65535\n";
  for (int j = 0; j < kHeight; ++j) {
    for (int i = 0; i < kWidth; ++i) {
      const double x = (i - kWidth / 2.0) * kColumn, y = (j - kHeight / 2.0) * kRow;
      const int z = std::fabs(x - centre_x) <= 30 && std::fabs(y - centre_y) <= 30 ? 800 : 900;
      pgm += {static_cast<char>(z / 256), static_cast<char>(z % 256)};
    }
  }
  write("kinect.pgm", pgm);
  const int u = static_cast<int>(std::lround(kWidth / 2.0 + centre_x / kColumn));
  const int v = static_cast<int>(std::lround(kHeight / 2.0 + centre_y / kRow));
  const std::string call = "infer " + path("zero.pb") + " --depth " + path("kinect.pgm") + " --click " +
                           std::to_string(u) + "," + std::to_string(v) + " --json";
  const Ran ran = run(call);
  ASSERT_EQ(ran.code, 0) << ran.out;
  const json camera = json::parse(ran.out)["camera"];
  const double clicked[] = {(u - 320) * kColumn / 1e3, (v - 240) * kRow / 1e3, 0.8};
  const double middle[] = {centre_x / 1e3, centre_y / 1e3, 0.8};
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(camera["clicked_point"][k].get<double>(), clicked[k], 1e-4) << k;
    EXPECT_NEAR(camera["tool"]["position"][k].get<double>(), middle[k], 0.01)
        << k << ": outputs of 0 aim at it";
  }
  // Seen through a lens of 525 pixels the same frame shows another place.
  write("lens.json",
        R"({"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "units_per_metre": 1000, "invalid": 0})");
  const Ran lens = run(call + " --camera " + path("lens.json"));
  ASSERT_EQ(lens.code, 0) << lens.out;
  EXPECT_NEAR(json::parse(lens.out)["camera"]["clicked_point"][0].get<double>(), (u - 319.5) / 525 * 0.8,
              2e-3);
}

TEST_F(Look, MistakesAreNamedAndHaveTheirExitCodes) {
  write_champion("zero.pb", {0, 0, 0, 0, 0, 0, 0});
  write("eight.png", *sim::encode_png(sim::ColourImage(8, 8)));
  const auto refused = [&](int code, const std::string& arguments, const std::string& says) {
    const Ran ran = run(arguments);
    EXPECT_EQ(ran.code, code) << arguments << '\n' << ran.out;
    EXPECT_THAT(ran.out, HasSubstr(says)) << arguments;
  };
  refused(2, "sim --pose '1 2 3'", "seven numbers");
  refused(2, "sim --pose '1 2 3 4 5 6 x'", "seven numbers");
  refused(2, "sim --object cube --target 3", "counted from 0");
  refused(2, "sim --pose '0 0 0 0 0 1 0' --champion x", "exclude");
  refused(2, "render --view behind --out " + path("x.png"), "unknown view");
  refused(2, "render --size 10 --out " + path("x.png"), "WIDTHxHEIGHT");
  refused(4, "sim --champion " + path("nobody.pb"), "nobody.pb");
  const std::string infer = "infer " + path("zero.pb") + " --click 3,3 --depth ";
  refused(4, infer + path("missing.png"), "no such file");
  refused(3, infer + path("eight.png"), "16-bit grey");
  write("not.json", "{]");
  write("grey.pgm", "P5 2 2 65535\n" + std::string(8, '\1'));
  refused(3, infer + path("grey.pgm") + " --camera " + path("not.json"), "not.json");
  refused(2, infer + path("grey.pgm"), "outside");
}

// Frames of real sensors.
TEST_F(Look, RealFramesAreReadAndAnswered) {
  write_champion("zero.pb", {0, 0, 0, 0, 0, 0, 0});
  const fs::path data = testing::data_folder();
  if (data.empty()) return;
  int frames = 0;
  for (const fs::directory_entry& frame : fs::directory_iterator(data / "depth")) {
    if (!frame.is_directory()) continue;
    ++frames;
    SCOPED_TRACE(frame.path().filename().string());
    std::ifstream in(frame.path() / "camera.json");
    const json facts = json::parse(in);
    const auto image = sim::read_grey16(frame.path() / "depth.png");
    ASSERT_TRUE(image) << image.error().message;
    std::size_t valid = 0;
    for (const std::uint16_t value : image->value) valid += value != facts["invalid"];
    EXPECT_NEAR(static_cast<double>(valid) / static_cast<double>(image->value.size()),
                facts["valid_fraction"], 1e-3);
    const Ran ran = run("infer " + path("zero.pb") + " --depth " + (frame.path() / "depth.png").string() +
                        " --camera " + (frame.path() / "camera.json").string() + " --click 320,240 --json");
    ASSERT_EQ(ran.code, 0) << ran.out;
    // Warnings come first: of notes in the camera's file, of surfaces farther than any in training.
    const std::string answer = ran.out.substr(std::min(ran.out.find("\n{"), ran.out.size() - 1) + 1);
    EXPECT_LT(json::parse(ran.out.starts_with('{') ? ran.out : answer)["distance_from_click"].get<double>(),
              0.3);
  }
  EXPECT_GE(frames, 4);
}

TEST(ParsePose, TurnsTheHomeOrientation) {
  const Pose pose = *parse_axis_angle_pose("1,2,3 0 0 2 1.5707963267948966", Mat3::Identity());
  EXPECT_EQ(pose.position, Vec3(1, 2, 3));
  EXPECT_LT((pose.rotation * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm(), 1e-12);
  EXPECT_FALSE(parse_axis_angle_pose("1 2 3 4 5 6 7 8", Mat3::Identity()));
  EXPECT_FALSE(parse_quaternion_pose("1 2 3 0 0 0 0", "--camera-pose"));
  EXPECT_LT(
      (parse_quaternion_pose("0 0 0 0 0 0 2", "--camera-pose")->rotation * Vec3(1, 0, 0) + Vec3(1, 0, 0))
          .norm(),
      1e-12);
}

TEST_F(Look, TestSeesWhatTheChampionWasTrainedToSee) {
  proto::TrialsConfig whole_image;
  whole_image.set_bounding_box(false);
  write_champion("window.pb", {0, 0, 0, 0, 0, 0, 0});
  write_champion("image.pb", {0, 0, 0, 0, 0, 0, 0}, whole_image);
  const auto box = [&](const std::string& champion, const std::string& flag) {
    const Ran ran = run("test " + path(champion) + " --placements 2 --no-lift --threads 1 --json " + flag);
    EXPECT_EQ(ran.code, 0) << ran.out;
    const json answer = json::parse(ran.out, nullptr, false);
    return answer.is_object() && answer.value("bounding_box", json()).is_boolean()
               ? answer["bounding_box"].get<bool>() ? "window" : "image"
               : "no answer";
  };
  EXPECT_STREQ(box("window.pb", ""), "window");
  EXPECT_STREQ(box("image.pb", ""), "image");
  EXPECT_STREQ(box("window.pb", "--no-box"), "image");
  EXPECT_STREQ(box("image.pb", "--box"), "window");
}

}  // namespace
}  // namespace evograsp::cli

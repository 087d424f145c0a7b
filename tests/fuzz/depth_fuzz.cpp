// A recorded depth image, PNG or PGM, as `evograsp infer` takes it: decoded, segmented, sampled.
#include "sim/camera.h"
#include "sim/depth_image.h"
#include "sim/png.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace evograsp;

void look(const sim::GreyImage& image, bool kinect) {
  static const proto::CameraConfig config;
  static const proto::GraspConfig grasp;
  static const sim::Camera training = *sim::Camera::create([] {
    proto::CameraConfig camera;
    camera.mutable_eye()->set_x(0.55);
    camera.mutable_eye()->set_z(0.55);
    return camera;
  }());
  sim::ImageCamera camera;
  camera.registered_kinect = kinect;
  const auto depth = sim::DepthImage::create(image, camera);
  fuzz::require(depth.has_value(), "a decoded image is an image");
  for (const auto& [u, v] : {std::pair{0, 0}, {image.width / 2, image.height / 2}, {image.width, 0}}) {
    const auto info = sim::look_at_recording(*depth, config, training, grasp, u, v, {});
    if (!info) continue;
    fuzz::require(info->depth.size() == std::size_t{config.columns()} * config.rows(),
                  "every sample is there");
    for (const float d : info->depth) fuzz::require(d >= 0 && d <= 1, "samples are within 0 and 1");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto image = sim::decode_grey16({reinterpret_cast<const char*>(data), size}, "image");
  if (!image) {
    fuzz::require(image.error().message.starts_with("image: "), "a refusal names the file");
    return 0;
  }
  fuzz::require(
      image->value.size() == static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height),
      "an image has all its pixels");
  for (const bool kinect : {false, true}) look(*image, kinect);
  return 0;
}

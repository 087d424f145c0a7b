// What recorded a depth image, as its user describes it.
#pragma once

#include <string>

#include "common/result.h"
#include "sim/depth_image.h"

namespace evograsp::cli {

// The camera that recorded `image`: JSON with fx, fy, cx, cy (pixels, required), units_per_metre (of the
// samples, up to 1e6; default: 1000), invalid (the sample that means none; default: 0), width and height
// (which must be the image's). Without a file: a registered Kinect frame in millimetres. Keys without a
// meaning are told. Errors name the file: not JSON, a key missing, twice or misspelt, a number outside of its
// range, optics that no camera of such an image has.
Result<sim::ImageCamera> read_camera(const std::string& file, const sim::GreyImage& image);

}  // namespace evograsp::cli

// Recorded depth images as input of a network: the same samples, the same normalisation, another camera.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/config.pb.h"
#include "sim/camera.h"
#include "sim/png.h"
#include "sim/simulator.h"

namespace evograsp::sim {

// The camera that recorded an image.
struct ImageCamera {
  double fx = 525, fy = 525, cx = 319.5, cy = 239.5;  // pixels
  double units_per_metre = 1000;                      // of the stored values
  std::uint16_t invalid = 0;                          // the stored value of a pixel without reading
  bool registered_kinect = false;  // project by registered_kinect_point() instead of fx, fy, cx, cy
};

// The point under pixel (i, j) of a registered Kinect frame of w x h pixels with reading z_mm, in metres,
// camera frame (the thesis, eq. 6.1 to 6.3): x = (i - w/2)(z + m) s (w/h), y = (j - h/2)(z + m) s, z = z with
// m = -100 mm and s = 0.0021.
Vec3 registered_kinect_point(double i, double j, double z_mm, int w, int h);

// A recorded image, in metres along the optical axis. Immutable and thread-safe.
class DepthImage {
 public:
  // Errors: no pixels, intrinsics that are not finite and positive, units_per_metre outside (0, 1e6].
  static Result<DepthImage> create(const GreyImage& image, const ImageCamera& camera);

  int width() const { return width_; }
  int height() const { return height_; }
  // Metres, or nothing where the sensor gave no reading or outside the image.
  std::optional<double> reading(int u, int v) const;
  // How holes are filled. The sensor's shadow beside an object shows what lies behind it, so a hole takes the
  // farthest reading of the nearest square ring (at most kHoleReach pixels away) that has any; `nearest`
  // takes the nearest reading of that ring instead: under a click it is the object.
  std::optional<double> filled(int u, int v, bool nearest = false) const;
  // The point at depth z under a pixel, camera frame (x right, y down, z forward).
  Vec3 point(const Pixel& pixel, double z) const;
  // Where the ray (a, b, 1) meets the image for a surface at depth z.
  Pixel pixel_of(double a, double b, double z) const;

 private:
  ImageCamera camera_;
  int width_ = 0, height_ = 0;
  std::vector<float> metres_;  // 0: hole
};
inline constexpr int kHoleReach = 24;

// The pixels of the clicked object.
struct Segment {
  int left = 0, top = 0, right = 0, bottom = 0;  // inclusive
  std::size_t pixels = 0;
  Pixel centre() const { return {(left + right) / 2.0, (top + bottom) / 2.0}; }
};
// Grows from the clicked pixel over neighbours whose depths join without a step and that stand at least 8 mm
// off the plane on which most points around the click lie (RANSAC; Fischler and Bolles 1981; fixed random
// stream). Nothing when the click is on that plane, or what has grown is no object (under 30 pixels, or over
// a quarter of the image).
std::optional<Segment> segment_clicked(const DepthImage& image, int u, int v);

struct RecordedOptions {
  bool bounding_box = true;
  // With the box: see the object as if it stood where the training camera looks (depths moved, window
  // scaled), because a network knows one distance only.
  bool at_training_distance = true;
  // With the box: centre the window on the clicked object (segment_clicked), as in training, instead of on
  // the click.
  bool centre_on_object = true;
};

// What the network sees of a recorded image, clicked at pixel (u, v). Positions of the answer (point, anchor)
// are in the world of the training camera: the frame in which `training` has its pose. Take them to the
// recording camera by training.pose().inverse(). Errors: the click is outside the image, or no reading within
// kHoleReach pixels of it.
Result<Info> look_at_recording(const DepthImage& image, const proto::CameraConfig& config,
                               const Camera& training, const proto::GraspConfig& grasp, int u, int v,
                               const RecordedOptions& options);

}  // namespace evograsp::sim

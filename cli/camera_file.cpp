#include "cli/camera_file.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "cli/json_input.h"
#include "cli/report.h"
#include "common/config.h"
#include "common/near_miss.h"

namespace evograsp::cli {
namespace {

constexpr double kMostUnits = 1e6;  // a metre

// Reads a number of camera.json; absent ones keep their default.
Status read_number(const nlohmann::json& json, const char* key, const std::string& file, double* value) {
  const auto at = json.find(key);
  if (at == json.end()) return {};
  if (!at->is_number() || !std::isfinite(at->get<double>()))
    return fail(ErrorCode::kInvalid, file + ": " + key + " must be a number");
  *value = at->get<double>();
  return {};
}

// Keys that mean nothing here may be notes of whoever recorded; but what looks like one of ours misspelt, or
// stands where a unit is missing, would give a pose at another scale.
Status check_keys(const nlohmann::json& json, const std::string& file) {
  static const std::vector<std::string> kKeys = {"fx",    "fy",     "cx",     "cy", "units_per_metre",
                                                 "width", "height", "invalid"};
  std::vector<std::string> unknown;
  for (const auto& [key, value] : json.items()) {
    if (std::ranges::find(kKeys, key) != kKeys.end()) continue;
    if (const std::string meant = did_you_mean(key, kKeys); !meant.empty())
      return fail(ErrorCode::kInvalid, file + ": unknown key '" + key + "'" + meant);
    unknown.push_back(key);
  }
  if (unknown.empty()) return {};
  if (!json.contains("units_per_metre"))
    return fail(ErrorCode::kInvalid,
                file + ": unknown keys: " + join_words(unknown) +
                    "; with such keys units_per_metre must be given (1000: millimetres)");
  warn(file + ": keys without a meaning here: " + join_words(unknown));
  return {};
}

// An optical axis far outside the image, or a view of almost nothing or almost everything, is a mistake.
Status check_optics(const sim::ImageCamera& camera, const sim::GreyImage& image, const std::string& file) {
  const auto sound = [](double f, double c, int pixels) {
    return f >= 0.05 * pixels && f <= 100.0 * pixels && c >= -2.0 * pixels && c <= 3.0 * pixels;
  };
  if (sound(camera.fx, camera.cx, image.width) && sound(camera.fy, camera.cy, image.height)) return {};
  return fail(ErrorCode::kInvalid, file + ": fx, fy, cx and cy are no camera's that records " +
                                       std::to_string(image.width) + " x " + std::to_string(image.height) +
                                       " pixels");
}

}  // namespace

Result<sim::ImageCamera> read_camera(const std::string& file, const sim::GreyImage& image) {
  sim::ImageCamera camera;
  if (file.empty()) {
    camera.registered_kinect = true;
    return camera;
  }
  const auto text = read_file(file);
  if (!text) return tl::unexpected(text.error());
  const nlohmann::json json = parse_json(*text, Duplicates::kRefuse);
  if (!json.is_object())
    return fail(ErrorCode::kInvalid, file + ": is not a JSON object with fx, fy, cx and cy, once each");
  if (Status s = check_keys(json, file); !s) return tl::unexpected(s.error());
  double width = image.width, height = image.height, invalid = 0;
  for (const char* key : {"fx", "fy", "cx", "cy"})
    if (!json.contains(key)) return fail(ErrorCode::kInvalid, file + ": " + key + " is missing");
  for (const auto& [key, value] : {std::pair{"fx", &camera.fx},
                                   {"fy", &camera.fy},
                                   {"cx", &camera.cx},
                                   {"cy", &camera.cy},
                                   {"units_per_metre", &camera.units_per_metre},
                                   {"invalid", &invalid},
                                   {"width", &width},
                                   {"height", &height}})
    if (Status s = read_number(json, key, file, value); !s) return tl::unexpected(s.error());
  if (width != image.width || height != image.height)
    return fail(ErrorCode::kInvalid, file + ": describes an image of another size; this one has " +
                                         std::to_string(image.width) + " x " + std::to_string(image.height) +
                                         " pixels");
  if (!(invalid >= 0 && invalid <= 65535) || invalid != std::floor(invalid))
    return fail(ErrorCode::kInvalid, file + ": invalid must be a whole number, 0 to 65535");
  if (!(camera.units_per_metre > 0 && camera.units_per_metre <= kMostUnits))
    return fail(ErrorCode::kInvalid, file + ": units_per_metre must lie above 0 and up to 1e6");
  camera.invalid = static_cast<std::uint16_t>(invalid);
  if (Status s = check_optics(camera, image, file); !s) return tl::unexpected(s.error());
  return camera;
}

}  // namespace evograsp::cli

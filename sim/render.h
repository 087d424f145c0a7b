// Pictures of a scene: a small ray tracer with one soft light, a sky and contact shadows. It sees bodies with
// the same intersections as the depth camera, so what a picture shows is what the simulator has.
#pragma once

#include <vector>

#include "common/pose.h"
#include "sim/camera.h"
#include "sim/png.h"
#include "sim/ray_caster.h"

namespace evograsp::sim {

// Linear light, red, green, blue.
struct Material {
  Vec3 colour = Vec3(0.5, 0.5, 0.5);
  double gloss = 0.2;  // weight of the highlight, 0 to 1
  double opacity = 1;  // glass bodies only
  double bevel_m = 0;  // edges are shaded round over this width
};

struct RenderItem {
  RayBody body;
  Pose X_WB;
  Material material;
};

struct RenderScene {
  std::vector<RenderItem> solid;
  // Marks that shine through: drawn over what is behind them, fainter where something stands before them.
  // They cast no shadow.
  std::vector<RenderItem> glass;
  double table_half = 0.5;  // m
};

struct RenderOptions {
  int supersampling = 2;  // rays a pixel and direction
  int light_samples = 9;  // shadow rays a primary ray, and as many sky rays
  int threads = 0;        // 0: one a core; the picture does not depend on it
};

// The camera's whole image, gamma-encoded (sRGB's 2.2). Deterministic.
ColourImage render(const RenderScene& scene, const Camera& camera, const RenderOptions& options = {});

// The depth under each pixel's centre in `units_per_metre` (0: no return, or beyond 16 bits): what a sensor
// would record, readable by DepthImage.
GreyImage render_depth(const PosedScene& scene, const Camera& camera, double units_per_metre);

}  // namespace evograsp::sim

// Flags that sim and render share: which scene, which hand, which pose.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/sim_session.h"
#include "common/config.h"
#include "common/result.h"
#include "proto/genome.pb.h"

namespace evograsp::cli {

// --box and --no-box; neither: as configured.
struct BoxFlags {
  bool on = false, off = false;
  bool choose(bool configured) const { return on || (configured && !off); }
};
void add_box_flags(CLI::App& sub, BoxFlags& flags);

struct SceneFlags {
  std::string config;                // file or built-in name; empty: the defaults
  std::string champion;              // file or run folder
  std::vector<std::string> objects;  // names or files; empty: the config's or the champion's
  std::string hand;
  std::vector<std::string> overrides;
  double scale = 0, mass = 0;  // of mesh files; 0: as configured
  std::uint64_t seed = 1;
  int target = -1;  // -1: the first object in the scene
  int click = 0;
  std::string pose;  // "x y z ax ay az r"
  BoxFlags box;
  std::string connect;   // a master whose workers simulate; empty: this process
  std::string key_file;  // for it
};

void add_scene_flags(CLI::App& sub, SceneFlags& flags);

// A trial made ready by the flags: shuffled, looked at, and with the pose that is commanded, if any.
struct Trial {
  std::unique_ptr<SimSession> session;
  proto::Config config;  // scene, camera, grasp, trials and fitness
  sim::Placements placements;
  int target = 0;
  bool bounding_box = true;
  std::optional<sim::Info> info;  // absent when no pixel of the target is visible and no network needs one
  std::optional<Pose> tool;       // X_WT, world
};

// Errors: usage (--pose and --champion together, a pose that is not seven numbers), and those of what the
// flags name. Warnings go to stderr.
Result<Trial> prepare_trial(const SceneFlags& flags);

// Seven numbers "x y z ax ay az r": position (m), rotation axis, angle (rad) about it, applied to `home`.
Result<Pose> parse_axis_angle_pose(const std::string& text, const Mat3& home);
// Seven numbers "x y z qw qx qy qz".
Result<Pose> parse_quaternion_pose(const std::string& text, const std::string& flag);

}  // namespace evograsp::cli

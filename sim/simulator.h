// The grasp simulator's only door: cmd_shuffle, cmd_get_info, cmd_get_quality (the thesis, 4.2.2.2).
//
// Simulator is immutable and thread-safe: one a process serves every slot. What a slot needs to scribble on
// is in its Workspace. A trial is a pure function of (experiment, pose, trial key): no state survives it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "common/version.h"
#include "proto/bundle.pb.h"
#include "proto/wire.pb.h"

namespace evograsp::sim {

inline constexpr int kSemanticVersion = kTrialVersion;  // common/version.h: bump it there

// Where every object of the scene stands (cmd_shuffle's answer).
struct Placements {
  std::uint64_t seed = 0;
  std::vector<Pose> pose;             // X_WB of each object of the experiment
  std::vector<std::uint8_t> resting;  // index of the resting pose
  std::vector<std::uint8_t> present;  // 0: not in this scene
  std::vector<double> scale;          // size over the size as modelled; empty: all 1

  double scale_of(std::size_t object) const { return object < scale.size() ? scale[object] : 1; }
};

// What the network sees (cmd_get_info's answer).
struct Info {
  std::vector<float> depth;         // rows x columns, row by row from the top left, [0, 1]; 1 = no return
  double click_a = 0, click_b = 0;  // click in [0, 1] of the image's width and height
  double box_w = 0, box_h = 0;      // size of the target's image bounding box, in [0, 1] of the image
  Vec3 point = Vec3::Zero();        // surface point under the click, world, m
  Vec3 anchor = Vec3::Zero();       // what the network's position output is relative to, world, m
  std::vector<float> features;      // camera.feature, in its order (sim/view_features.h)
  // The network's input vector: depth, a, b, w, h, features (the bias is the network's own).
  std::size_t input_count() const { return depth.size() + 4 + features.size(); }
  void write_inputs(std::span<float> inputs) const;
};

struct Contact {
  Vec3 point;   // on the target's surface, world, m
  Vec3 normal;  // unit, into the target, world
  double mu;
  int link;    // hand link
  int part;    // convex part of the target
  double gap;  // m
};

struct Measurement {
  proto::Outcome outcome = proto::MISSED;
  double quality = 0;  // epsilon (Ferrari and Canny 1992); 0 without force closure
  int contacts = 0;
  int obstructions = 0;
  Vec3 p = Vec3::Zero(), s = Vec3::Zero(), o = Vec3::Zero();
  double nearest_object = 0, target_distance = 0, theta = 0;  // m, m, degrees
};

// Everything about one attempt, for pictures and debugging.
struct GraspReport {
  Measurement measurement;
  std::vector<Contact> contacts;  // canonical order: link, part, then coordinates
  std::vector<double> joints;     // rad or m, closed
  Pose palm;                      // X_WH where the hand stopped
};

// Scratch memory of one slot, made by the Simulator it is used with; never shared between threads. What a
// trial leaves in it changes no bit of the next.
class Workspace {
 public:
  virtual ~Workspace() = default;
};

class Simulator {
 public:
  // Everything is checked here; a Simulator that exists can run any trial. Objects in scene order.
  static Result<std::shared_ptr<const Simulator>> create(const proto::Experiment& experiment,
                                                         const std::vector<proto::ObjectBundle>& objects,
                                                         const proto::HandBundle& hand);
  virtual ~Simulator() = default;

  virtual std::unique_ptr<Workspace> make_workspace() const = 0;

  // cmd_shuffle: position, yaw, resting face and size of each object; no overlaps; inside the view. An error
  // after scene.placement_tries when the scene is too crowded.
  virtual Result<Placements> shuffle(std::uint64_t seed) const = 0;

  // cmd_get_info. The click is a uniformly random visible pixel of the target, drawn by (seed, target,
  // click). An error when no pixel of the target is visible.
  virtual Result<Info> get_info(const Placements& placements, int target, int click,
                                bool bounding_box) const = 0;

  // cmd_get_quality: one grasp attempt. `tool` is the commanded pose X_WT of the tool frame: origin at the
  // hand's tool point, axes of the palm frame. Never fails: every pose has a defined outcome.
  // `details`, when given, receives the whole attempt (allocates).
  virtual Measurement get_quality(const Placements& placements, int target, const Pose& tool,
                                  Workspace& workspace, GraspReport* details = nullptr) const = 0;

  // The network's 7 outputs (each in [-1, 1]: x, y, z, axis, angle) as a tool pose: position in the workspace
  // about info.anchor, rotation applied to the home orientation. Non-finite outputs give a
  // non-finite pose, which get_quality answers with NOT_A_NUMBER.
  virtual Pose decode(std::span<const float> outputs, const Info& info, bool bounding_box) const = 0;

  virtual int object_count() const = 0;
  virtual int inputs() const = 0;  // columns x rows + 4 + features
  virtual const proto::Experiment& experiment() const = 0;
  virtual const proto::ObjectBundle& object(int index) const = 0;
  virtual const proto::HandBundle& hand() const = 0;
};

inline constexpr int kOutputs = 7;

}  // namespace evograsp::sim

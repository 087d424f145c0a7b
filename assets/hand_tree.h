// A URDF's hand as a tree of moving links: the palm's subtree, fixed joints merged into their parents,
// parents before children.
#pragma once

#include <urdf_model/model.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/pose.h"
#include "common/result.h"
#include "proto/bundle.pb.h"
#include "proto/hand.pb.h"

namespace evograsp::assets {

inline constexpr std::size_t kMaxHandLinks = 64;

struct HandLink {
  std::string name;
  std::vector<proto::ConvexPart> parts;
  double mass = 0;
  Vec3 centre = Vec3::Zero();
};

struct HandJoint {
  std::string name;
  bool prismatic = false;
  int parent = 0;  // link index
  Pose origin;     // in the parent link
  Vec3 axis = Vec3::UnitX();
  double lower = 0, upper = 0;
  std::string mimic;  // leader's name; empty: none
  double multiplier = 1, offset = 0;
};

struct HandTree {
  std::vector<HandLink> links;    // 0: the palm
  std::vector<HandJoint> joints;  // joint i moves link i + 1
  // Where every link of the URDF's subtree went, merged ones too.
  struct Placed {
    int link;
    Pose pose;  // of the URDF link in `link`
  };
  std::map<std::string, Placed> placed;

  int find_joint(const std::string& name) const;  // -1: none
  // Link frames in the palm frame for joint values q (one a joint).
  std::vector<Pose> forward(const std::vector<double>& q) const;
};

// How collision geometry becomes parts, and where mesh files are.
struct GeometrySource {
  std::filesystem::path urdf_folder;  // empty: embedded, no meshes
  std::map<std::string, std::filesystem::path> packages;
  double rounding = 0.0005;
};

// X_LP: the palm frame in the palm link. Warnings name what was left out.
Result<HandTree> build_hand_tree(const urdf::ModelInterface& model, const std::string& palm_link,
                                 const Pose& X_LP, const GeometrySource& geometry,
                                 std::vector<std::string>& warnings);

}  // namespace evograsp::assets

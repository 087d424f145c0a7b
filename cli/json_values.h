// Poses, vectors and measurements as JSON. Numbers that are not finite become null.
#pragma once

#include <nlohmann/json.hpp>

#include "common/pose.h"
#include "proto/wire.pb.h"
#include "sim/simulator.h"

namespace evograsp::cli {

nlohmann::ordered_json to_json(const Vec3& v);     // [x, y, z]
nlohmann::ordered_json to_json(const Pose& pose);  // {"position": [...], "quaternion": [w, x, y, z]}
nlohmann::ordered_json to_json(const sim::Measurement& m);
const char* outcome_name(proto::Outcome outcome);  // "grasped", "missed", ...

}  // namespace evograsp::cli

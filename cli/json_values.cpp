#include "cli/json_values.h"

#include <cmath>

namespace evograsp::cli {

using Json = nlohmann::ordered_json;

namespace {

Json number(double x) {
  return std::isfinite(x) ? Json(x) : Json(nullptr);
}

}  // namespace

Json to_json(const Vec3& v) {
  return Json::array({number(v.x()), number(v.y()), number(v.z())});
}

Json to_json(const Pose& pose) {
  const proto::Quat q = evograsp::to_proto(pose.rotation);
  Json out;
  out["position"] = to_json(pose.position);
  out["quaternion"] = Json::array({number(q.w()), number(q.x()), number(q.y()), number(q.z())});
  return out;
}

const char* outcome_name(proto::Outcome outcome) {
  switch (outcome) {
    case proto::GRASPED:
      return "grasped";
    case proto::MISSED:
      return "missed";
    case proto::BLOCKED:
      return "blocked";
    case proto::UNREACHABLE:
      return "unreachable";
    case proto::NOT_A_NUMBER:
      return "not_a_number";
    case proto::NO_TRIAL:
      return "no_trial";
  }
  return "unknown";
}

Json to_json(const sim::Measurement& m) {
  Json out;
  out["outcome"] = outcome_name(m.outcome);
  out["force_closure"] = m.quality > 0;
  out["quality"] = number(m.quality);
  out["contacts"] = m.contacts;
  out["obstructions"] = m.obstructions;
  out["asked"] = to_json(m.p);
  out["reached"] = to_json(m.s);
  out["target_centre"] = to_json(m.o);
  out["nearest_object"] = number(m.nearest_object);
  out["target_distance"] = number(m.target_distance);
  out["theta"] = number(m.theta);
  return out;
}

}  // namespace evograsp::cli

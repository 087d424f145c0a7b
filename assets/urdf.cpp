#include "assets/urdf.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <exception>

#include "assets/plain_xml.h"
#include "common/mutex.h"

namespace evograsp::assets {
namespace {

// Collects what urdfdom says instead of printing it.
class Listener : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR || heard_.size() > 1000) return;
    heard_ += (heard_.empty() ? "" : "; ") + text;
  }
  const std::string& heard() const { return heard_; }

 private:
  std::string heard_;
};

double snap(double v) {
  constexpr double kGrid = 1099511627776.0;  // 2^40
  return std::floor(v * kGrid + 0.5) / kGrid;
}

}  // namespace

Result<urdf::ModelInterfaceSharedPtr> parse_urdf(std::string_view text, const std::string& file_name) {
  if (text.size() > kMaxUrdf) return fail(ErrorCode::kInvalid, file_name + ": larger than the 4 MiB allowed");
  const Result<std::string> plain = plain_xml(text);
  if (!plain) return fail(ErrorCode::kInvalid, file_name + ": not a usable URDF: " + plain.error().message);
  static Mutex mutex;  // console_bridge's handler is one for the process
  const MutexLock lock(mutex);
  Listener listener;
  console_bridge::useOutputHandler(&listener);
  urdf::ModelInterfaceSharedPtr model;
  std::string thrown;
  try {
    model = urdf::parseURDF(*plain);
  } catch (const std::exception& e) {
    thrown = e.what();
  }
  console_bridge::restorePreviousOutputHandler();
  if (!model || !model->getRoot()) {
    std::string reason = listener.heard().empty() ? thrown : listener.heard();
    if (reason.empty()) reason = "no <robot> with a root link";
    return fail(ErrorCode::kInvalid, file_name + ": not a usable URDF: " + reason);
  }
  if (model->links_.size() > kMaxUrdfLinks) {
    return fail(ErrorCode::kInvalid, file_name + ": more than " + std::to_string(kMaxUrdfLinks) + " links");
  }
  return model;
}

Pose snapped(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  Pose out{rotation_from_quaternion(snap(q.w), snap(q.x), snap(q.y), snap(q.z)),
           {pose.position.x, pose.position.y, pose.position.z}};
  for (int i = 0; i < 9; ++i) {  // quarter turns come out exact
    double& v = out.rotation.data()[i];
    const double whole = std::floor(v + 0.5);
    if (std::fabs(v - whole) < 1e-9) v = whole;
  }
  return out;
}

}  // namespace evograsp::assets

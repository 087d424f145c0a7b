#include <algorithm>
#include <cmath>

#include "assets/assets.h"
#include "assets/bundle.h"
#include "assets/hand_guess.h"
#include "assets/hand_tree.h"
#include "assets/parts.h"
#include "assets/text.h"
#include "assets/urdf.h"
#include "proto/hand.pb.h"

namespace evograsp::assets {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxHandFile = 1 << 20;  // bytes
constexpr double kDefaultMass = 0.01;          // kg, of links without <inertial>

// Puts a hand file's facts on a tree. Every failure names the field.
class Assembler {
 public:
  Assembler(const HandTree& tree, const proto::HandFile& file, LoadedHand& out)
      : tree_(tree), file_(file), out_(out), bundle_(out.bundle) {}

  Status assemble() {
    bundle_.set_name(file_.name());
    for (const Status& step : {frame(), presets(), motors(), thumb(), materials()}) {
      if (!step) return step;
    }
    bundle_.set_standoff(file_.standoff());
    bundle_.set_open_width(file_.open_width());
    return {};
  }

 private:
  Status frame() {
    const auto a =
        direction_of(file_.has_approach_axis() ? from_proto(file_.approach_axis()) : Vec3(Vec3::UnitZ()));
    const auto f =
        direction_of(file_.has_finger_axis() ? from_proto(file_.finger_axis()) : Vec3(Vec3::UnitX()));
    if (!a) return bad("approach_axis: must be finite and not zero");
    if (!f) return bad("finger_axis: must be finite and not zero");
    if (std::fabs(a->dot(*f)) > 0.99) return bad("finger_axis: must not be parallel to approach_axis");
    *bundle_.mutable_approach_axis() = to_proto(*a);
    *bundle_.mutable_finger_axis() = to_proto(*f);
    const Vec3 tool = from_proto(file_.tool_point());
    if (!is_finite(tool) || tool.norm() > 1) return bad("tool_point: must be within 1 m of the palm");
    *bundle_.mutable_tool_point() = to_proto(tool);
    return {};
  }

  Status presets() {
    std::vector<double> value;
    for (const HandJoint& joint : tree_.joints) value.push_back(std::clamp(0.0, joint.lower, joint.upper));
    for (const proto::JointValue& preset : file_.preset()) {
      const int i = tree_.find_joint(preset.joint());
      if (i < 0) return bad("preset: the hand has no moving joint '" + preset.joint() + "'");
      const HandJoint& joint = tree_.joints[i];
      if (!(preset.value() >= joint.lower && preset.value() <= joint.upper)) {
        return bad("preset of '" + preset.joint() + "': " + std::to_string(preset.value()) +
                   " is outside the limits " + std::to_string(joint.lower) + " to " +
                   std::to_string(joint.upper));
      }
      value[i] = preset.value();
    }
    bundle_.mutable_preset()->Add(value.begin(), value.end());
    return {};
  }

  Status motors() {
    std::vector<int> driver(tree_.joints.size(), -1);
    for (const proto::Motor& motor : file_.motor()) {
      proto::HandBundle::Motor& m = *bundle_.add_motor();
      m.set_name(motor.name());
      m.set_max_torque(motor.max_torque());
      m.set_speed(motor.speed());
      m.set_hold(motor.hold());
      for (const proto::Coupling& coupling : motor.joint()) {
        const int i = tree_.find_joint(coupling.joint());
        if (i < 0)
          return bad("motor '" + motor.name() + "': the hand has no moving joint '" + coupling.joint() + "'");
        if (driver[i] >= 0) return bad("joint '" + coupling.joint() + "' is driven twice");
        if (!std::isfinite(coupling.ratio()) || coupling.ratio() == 0) {
          return bad("motor '" + motor.name() + "': the ratio of '" + coupling.joint() +
                     "' must be finite and not zero");
        }
        drive(m, driver, i, coupling.ratio());
      }
      if (m.joint_size() == 0) return bad("motor '" + motor.name() + "': drives no joint");
    }
    follow_leaders(driver);
    if (std::none_of(file_.motor().begin(), file_.motor().end(), [](const auto& m) { return !m.hold(); })) {
      return bad("no motor closes anything");
    }
    joints(driver);
    return {};
  }

  void drive(proto::HandBundle::Motor& motor, std::vector<int>& driver, int joint, double ratio) {
    driver[joint] = bundle_.motor_size() - 1;
    motor.add_joint(static_cast<std::uint32_t>(joint));
    motor.add_ratio(ratio);
  }

  // A <mimic> joint that no motor names moves with its leader.
  void follow_leaders(std::vector<int>& driver) {
    bool again = true;
    while (again) {  // a follower may follow a follower
      again = false;
      for (std::size_t i = 0; i < tree_.joints.size(); ++i) {
        const HandJoint& joint = tree_.joints[i];
        const int leader = joint.mimic.empty() ? -1 : tree_.find_joint(joint.mimic);
        if (driver[i] >= 0 || leader < 0 || driver[leader] < 0 || joint.multiplier == 0) continue;
        proto::HandBundle::Motor& motor = *bundle_.mutable_motor(driver[leader]);
        const auto slot =
            std::find(motor.joint().begin(), motor.joint().end(), static_cast<std::uint32_t>(leader));
        const double leader_ratio = motor.ratio(static_cast<int>(slot - motor.joint().begin()));
        motor.add_joint(static_cast<std::uint32_t>(i));  // moves the list: slot is void from here on
        motor.add_ratio(leader_ratio * joint.multiplier);
        driver[i] = driver[leader];
        again = true;
      }
    }
  }

  void joints(const std::vector<int>& driver) {
    std::vector<std::string> idle;
    for (std::size_t i = 0; i < tree_.joints.size(); ++i) {
      const HandJoint& joint = tree_.joints[i];
      proto::HandBundle::Joint& out = *bundle_.add_joint();
      out.set_name(joint.name);
      out.set_prismatic(joint.prismatic);
      out.set_parent_link(static_cast<std::uint32_t>(joint.parent));
      *out.mutable_origin() = to_proto(joint.origin);
      *out.mutable_axis() = to_proto(joint.axis);
      out.set_lower(joint.lower);
      out.set_upper(joint.upper);
      out.set_locked(driver[i] < 0);
      if (driver[i] < 0) idle.push_back(joint.name);
    }
    warn("joint", idle, "no motor moves it, it stays at its preset");
  }

  // One warning for all that share it: "joint 'a' and 3 more: ...".
  void warn(const std::string& kind, const std::vector<std::string>& names, const std::string& what) {
    if (names.empty()) return;
    const std::string more = names.size() > 1 ? " and " + std::to_string(names.size() - 1) + " more" : "";
    out_.warnings.push_back(kind + " '" + names.front() + "'" + more + ": " + what);
  }

  Status thumb() {
    const std::string& name = file_.thumb_tip_link();
    if (name.empty()) return bad("thumb_tip_link: needed for the thumb's angle");
    const auto found = tree_.placed.find(name);
    if (found == tree_.placed.end()) return bad("thumb_tip_link: no link '" + name + "' below the palm");
    const Vec3 tip = found->second.pose * from_proto(file_.thumb_tip());
    if (!is_finite(tip)) return bad("thumb_tip: must be finite");
    bundle_.set_thumb_tip_link(static_cast<std::uint32_t>(found->second.link));
    *bundle_.mutable_thumb_tip() = to_proto(tip);
    return {};
  }

  Status materials() {
    std::vector<std::string> material(tree_.links.size(), file_.material());
    for (const proto::LinkMaterial& special : file_.link_material()) {
      const auto found = tree_.placed.find(special.link());
      if (found == tree_.placed.end())
        return bad("link_material: no link '" + special.link() + "' below the palm");
      material[found->second.link] = special.material();
    }
    std::vector<std::string> shapeless, massless;
    for (std::size_t i = 0; i < tree_.links.size(); ++i) {
      const HandLink& link = tree_.links[i];
      proto::HandBundle::Link& out = *bundle_.add_link();
      out.set_name(link.name);
      out.set_mass(link.mass > 0 ? link.mass : kDefaultMass);
      *out.mutable_centre_of_mass() = to_proto(link.centre);
      out.set_material(material[i]);
      for (const proto::ConvexPart& part : link.parts) *out.add_part() = part;
      if (link.parts.empty()) shapeless.push_back(link.name);
      if (!(link.mass > 0)) massless.push_back(link.name);
    }
    if (shapeless.size() == tree_.links.size()) return bad("no link has a usable collision shape");
    warn("link", shapeless, "no collision shape, it touches nothing");
    warn("link", massless, "no mass given, 10 g assumed");
    return {};
  }

  static Status bad(std::string message) { return fail(ErrorCode::kInvalid, std::move(message)); }

  const HandTree& tree_;
  const proto::HandFile& file_;
  LoadedHand& out_;
  proto::HandBundle& bundle_;
};

struct Source {
  std::string name;  // for messages
  std::string urdf_text;
  GeometrySource geometry;
};

Result<LoadedHand> assemble_hand(proto::HandFile file, const Source& source) {
  LoadedHand out;
  const auto in_file = [&](const Error& e) { return fail(e.code, source.name + ": " + e.message); };
  const Result<urdf::ModelInterfaceSharedPtr> model = parse_urdf(source.urdf_text, source.name);
  if (!model) return tl::unexpected(model.error());
  const bool bare = !file.has_palm_link();
  if (bare) {
    const Result<std::string> palm = guess_palm(**model);
    if (!palm) return in_file(palm.error());
    file.set_palm_link(*palm);
    out.warnings.push_back("no hand file: palm, axes, tool point and motors are guessed from the URDF");
  }
  const Result<HandTree> tree = build_hand_tree(**model, file.palm_link(), from_proto(file.palm_frame()),
                                                source.geometry, out.warnings);
  if (!tree) return in_file(tree.error());
  if (bare) guess_frame(*tree, file, out.warnings);
  if (file.motor().empty()) guess_motors(*tree, file, out.warnings);
  if (const Status ok = Assembler(*tree, file, out).assemble(); !ok) return in_file(ok.error());
  if (const Status ok = check_size(out.bundle); !ok) return in_file(ok.error());
  out.id = bundle_id(out.bundle);
  return out;
}

Result<LoadedHand> builtin_hand(const std::string& name) {
  proto::HandFile file;
  const std::string path = "hands/" + name + ".txtpb";
  if (const Status ok = parse_message(*embedded_file(path), path, file); !ok)
    return tl::unexpected(ok.error());
  const auto urdf = embedded_file("hands/" + file.urdf());
  if (!urdf) return fail(ErrorCode::kInternal, path + ": its URDF is not built in");
  Source source{path, std::string(*urdf), {}};
  source.geometry.rounding = file.rounding();
  return assemble_hand(std::move(file), source);
}

Result<LoadedHand> hand_from_file(const fs::path& path) {
  proto::HandFile file;
  fs::path urdf = path;
  if (path.extension() != ".urdf") {
    const Result<std::string> text = read_file(path, kMaxHandFile);
    if (!text) return tl::unexpected(text.error());
    if (const Status ok = parse_message(*text, path.string(), file); !ok) return tl::unexpected(ok.error());
    urdf = path.parent_path() / file.urdf();
  }
  if (!file.has_name()) file.set_name(path.stem().string());
  Result<std::string> urdf_text = read_file(urdf, kMaxUrdf);
  if (!urdf_text) return tl::unexpected(urdf_text.error());
  Source source{urdf.string(), std::move(*urdf_text), {}};
  source.geometry.urdf_folder = fs::absolute(urdf).parent_path();
  source.geometry.rounding = file.rounding();
  for (const proto::PackagePath& package : file.package()) {
    source.geometry.packages[package.name()] = fs::absolute(path).parent_path() / package.path();
  }
  return assemble_hand(std::move(file), source);
}

}  // namespace

std::vector<std::string> builtin_hands() {
  return builtin_names("hands/");
}

Result<LoadedHand> load_hand(const std::string& name_or_path, const fs::path& base) {
  if (embedded_file("hands/" + name_or_path + ".txtpb")) return builtin_hand(name_or_path);
  const fs::path path = find_file(name_or_path, base);
  if (path.empty()) return fail(ErrorCode::kNotFound, unknown_name("hand", name_or_path, builtin_hands()));
  return hand_from_file(path);
}

}  // namespace evograsp::assets

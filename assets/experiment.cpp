#include "assets/experiment.h"

#include <google/protobuf/descriptor.h>

#include <cmath>

#include "assets/bundle.h"
#include "common/digest.h"
#include "common/pose.h"
#include "common/version.h"

namespace evograsp::assets {
namespace {

namespace pb = google::protobuf;
constexpr int kMaxObjects = 256;

void write_default(pb::Message& message, const pb::FieldDescriptor& field) {
  const pb::Reflection& r = *message.GetReflection();
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_INT32:
      r.SetInt32(&message, &field, field.default_value_int32());
      break;
    case pb::FieldDescriptor::CPPTYPE_INT64:
      r.SetInt64(&message, &field, field.default_value_int64());
      break;
    case pb::FieldDescriptor::CPPTYPE_UINT32:
      r.SetUInt32(&message, &field, field.default_value_uint32());
      break;
    case pb::FieldDescriptor::CPPTYPE_UINT64:
      r.SetUInt64(&message, &field, field.default_value_uint64());
      break;
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      r.SetDouble(&message, &field, field.default_value_double());
      break;
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      r.SetFloat(&message, &field, field.default_value_float());
      break;
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      r.SetBool(&message, &field, field.default_value_bool());
      break;
    case pb::FieldDescriptor::CPPTYPE_ENUM:
      r.SetEnum(&message, &field, field.default_value_enum());
      break;
    case pb::FieldDescriptor::CPPTYPE_STRING:
      r.SetString(&message, &field, field.default_value_string());
      break;
    case pb::FieldDescriptor::CPPTYPE_MESSAGE:
      break;
  }
}

// Writes out every scalar default, also of messages that are there; absent messages stay absent.
void write_defaults(pb::Message& message) {
  const pb::Reflection& r = *message.GetReflection();
  const pb::Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    const bool is_message = field.cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE;
    if (field.is_repeated()) {
      for (int k = 0; is_message && k < r.FieldSize(message, &field); ++k) {
        write_defaults(*r.MutableRepeatedMessage(&message, &field, k));
      }
    } else if (is_message) {
      if (r.HasField(message, &field)) write_defaults(*r.MutableMessage(&message, &field));
    } else if (!r.HasField(message, &field) && field.real_containing_oneof() == nullptr) {
      write_default(message, field);
    }
  }
}

// The palm's orientation at zero rotation: approach axis down, finger axis towards -x as far as it can.
Mat3 default_home(const proto::HandBundle& hand) {
  const Vec3 a = from_proto(hand.approach_axis()), f = from_proto(hand.finger_axis());
  const Vec3 across = f - f.dot(a) * a;
  const Vec3 x = across / across.norm();
  Mat3 in_palm, in_world;
  in_palm << a, x, a.cross(x);
  in_world << Vec3(0, 0, -1), Vec3(-1, 0, 0), Vec3(0, 0, -1).cross(Vec3(-1, 0, 0));
  return in_world * in_palm.transpose();
}

// The defaults that the schema gives in words.
void write_worded_defaults(proto::Experiment& experiment, const proto::HandBundle& hand) {
  proto::CameraConfig& camera = *experiment.mutable_camera();
  if (!camera.has_eye()) *camera.mutable_eye() = to_proto(Vec3(0.55, 0, 0.55));
  proto::GraspConfig& grasp = *experiment.mutable_grasp();
  if (!grasp.has_workspace_box_half()) *grasp.mutable_workspace_box_half() = to_proto(Vec3(0.15, 0.15, 0.15));
  if (!grasp.has_workspace_centre()) *grasp.mutable_workspace_centre() = to_proto(Vec3(0, 0, 0.125));
  if (!grasp.has_workspace_half()) *grasp.mutable_workspace_half() = to_proto(Vec3(0.3, 0.3, 0.125));
  if (!grasp.has_home()) *grasp.mutable_home() = to_proto(Pose{default_home(hand), Vec3::Zero()});
  proto::SceneConfig& scene = *experiment.mutable_scene();
  if (!scene.has_mesh_mass()) scene.set_mesh_mass(0);
}

Status load_objects(const proto::SceneConfig& scene, const std::filesystem::path& base,
                    const Bundles& at_hand, ResolvedExperiment& out) {
  if (scene.object().empty()) return fail(ErrorCode::kInvalid, "scene.object: at least one object is needed");
  if (scene.object_size() > kMaxObjects) {
    return fail(ErrorCode::kInvalid, "scene.object: more than " + std::to_string(kMaxObjects) + " objects");
  }
  if (!at_hand.objects.empty()) {
    if (static_cast<int>(at_hand.objects.size()) != scene.object_size())
      return fail(ErrorCode::kInvalid,
                  "scene.object: " + std::to_string(at_hand.objects.size()) + " of them are at hand");
    out.objects = at_hand.objects;
    for (const proto::ObjectBundle& object : out.objects) out.experiment.add_object_id(bundle_id(object));
    return {};
  }
  const ObjectOptions options{scene.mesh_scale(), scene.mesh_mass(), base, {}};
  for (const std::string& name : scene.object()) {
    Result<LoadedObject> object = load_object(name, options);
    if (!object) return fail(object.error().code, "scene.object: " + object.error().message);
    for (const std::string& warning : object->warnings) out.warnings.push_back(name + ": " + warning);
    out.experiment.add_object_id(object->id);
    out.objects.push_back(std::move(object->bundle));
  }
  return {};
}

Result<LoadedHand> hand_of(const proto::GraspConfig& grasp, const std::filesystem::path& base,
                           const Bundles& at_hand) {
  if (at_hand.hand) return LoadedHand{*at_hand.hand, bundle_id(*at_hand.hand), {}};
  return load_hand(grasp.hand(), base);
}

}  // namespace

std::string stable_name(const std::string& name_or_path) {
  std::string name = std::filesystem::path(name_or_path).filename().string();
  return name.empty() ? name_or_path : name;
}

void make_names_stable(proto::SceneConfig* scene, proto::GraspConfig* grasp) {
  for (std::string& name : *scene->mutable_object()) name = stable_name(name);
  if (grasp->has_hand()) grasp->set_hand(stable_name(grasp->hand()));
}

std::string experiment_fingerprint(proto::Experiment experiment) {
  experiment.clear_fingerprint();
  return sha256_hex(deterministic_bytes(experiment) + "/" + std::to_string(kTrialVersion));
}

Result<ResolvedExperiment> resolve_experiment(const proto::Config& config,
                                              const std::filesystem::path& base) {
  return resolve_experiment(config, base, Bundles());
}

Result<ResolvedExperiment> resolve_experiment(const proto::Config& config, const std::filesystem::path& base,
                                              const Bundles& at_hand) {
  ResolvedExperiment out;
  proto::Experiment& experiment = out.experiment;
  *experiment.mutable_scene() = config.scene();
  *experiment.mutable_camera() = config.camera();
  *experiment.mutable_grasp() = config.grasp();
  *experiment.mutable_trials() = config.trials();
  write_defaults(experiment);
  experiment.clear_hand_id();
  Result<LoadedHand> hand = hand_of(experiment.grasp(), base, at_hand);
  if (!hand) return fail(hand.error().code, "grasp.hand: " + hand.error().message);
  for (const std::string& warning : hand->warnings)
    out.warnings.push_back(experiment.grasp().hand() + ": " + warning);
  write_worded_defaults(experiment, hand->bundle);
  if (const Status ok = load_objects(experiment.scene(), base, at_hand, out); !ok)
    return tl::unexpected(ok.error());
  make_names_stable(experiment.mutable_scene(), experiment.mutable_grasp());
  experiment.set_hand_id(hand->id);
  out.hand = std::move(hand->bundle);
  experiment.set_fingerprint(experiment_fingerprint(experiment));
  return out;
}

}  // namespace evograsp::assets

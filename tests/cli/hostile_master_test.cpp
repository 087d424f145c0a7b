// `evograsp sim --connect` before masters whose slots answer nonsense.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <map>
#include <thread>
#include <tuple>
#include <vector>

#include "assets/assets.h"
#include "cli/sim_session.h"
#include "common/config.h"
#include "common/pose.h"
#include "common/step_client.h"
#include "common/wire.h"

namespace evograsp::cli {
namespace {

using ::testing::HasSubstr;
using Twist = std::function<void(proto::StepReply&)>;

assets::ResolvedExperiment cube(const std::vector<proto::ViewFeature>& features) {
  proto::Config config;
  config.mutable_scene()->add_object("cube");
  config.mutable_camera(), config.mutable_grasp(), config.mutable_trials();
  for (const proto::ViewFeature feature : features) config.mutable_camera()->add_feature(feature);
  write_defaults(config);
  return *assets::resolve_experiment(config, {});
}

// Answers as a slot does, but for the features and for what `twist` makes of it; with `noise`, sends what
// nobody asked for instead.
class Master {
 public:
  explicit Master(Twist twist, const std::vector<proto::ViewFeature>& features = {}, bool noise = false)
      : what_(cube(features)), twist_(std::move(twist)), noise_(noise) {
    socket_ = std::move(*make_router(context_, SocketOptions()));
    endpoint_ = *bind(socket_, "tcp://127.0.0.1:*");
    packed_[what_.experiment.hand_id()] = assets::pack_bundle(what_.hand);
    packed_[what_.experiment.object_id(0)] = assets::pack_bundle(what_.objects[0]);
    thread_ = std::thread([this] { serve(); });
  }
  ~Master() {
    stopping_ = true;
    thread_.join();
  }
  const std::string& endpoint() const { return endpoint_; }
  const assets::ResolvedExperiment& what() const { return what_; }

 private:
  void serve() {
    while (!stopping_) {
      zmq::pollitem_t item{socket_.handle(), 0, ZMQ_POLLIN, 0};
      zmq::poll(&item, 1, std::chrono::milliseconds(10));
      google::protobuf::Arena arena;
      Received in;
      if (receive(socket_, true, arena, in) && in.envelope != nullptr) {
        peer_ = in.peer;
        answer(*in.envelope);
      } else if (noise_ && asked_) {
        proto::Envelope other = make_envelope(stamp_);
        other.mutable_asset_reply()->set_id("another");
        send(socket_, peer_, other);
      }
    }
  }

  void answer(const proto::Envelope& in) {
    proto::Envelope out = make_envelope(stamp_);
    std::vector<std::string_view> attachments;
    if (in.has_hello()) {
      *out.mutable_welcome()->mutable_experiment() = what_.experiment;
    } else if (in.has_asset_request()) {
      const std::string& id = in.asset_request().id();
      out.mutable_asset_reply()->set_id(id);
      out.mutable_asset_reply()->set_found(true);
      attachments.push_back(packed_.at(id));
    } else if (in.has_step_request()) {
      asked_ = true;
      if (noise_) return;
      out.mutable_step_reply()->set_id(in.step_request().id());
      reply_to(in.step_request(), *out.mutable_step_reply());
      twist_(*out.mutable_step_reply());
    }
    send(socket_, peer_, to_frame(out, attachments));
  }

  void reply_to(const proto::StepRequest& request, proto::StepReply& reply) const {
    if (request.has_shuffle()) {
      *reply.mutable_placements()->add_object()->mutable_pose() = to_proto(Pose());
    } else if (request.has_get_quality()) {
      for (int i = 0; i < what_.hand.joint_size(); ++i) reply.mutable_grasp()->add_joint(0.1);
    } else {
      const proto::CameraConfig& camera = what_.experiment.camera();
      for (std::uint32_t i = 0; i < camera.columns() * camera.rows(); ++i) reply.mutable_info()->add_depth(1);
    }
  }

  const SessionStamp stamp_{7, 1};
  const assets::ResolvedExperiment what_;
  const Twist twist_;
  const bool noise_;
  zmq::context_t context_{1};
  zmq::socket_t socket_;
  std::string endpoint_, peer_;
  std::map<std::string, std::string> packed_;
  std::atomic<bool> stopping_{false};
  bool asked_ = false;
  std::thread thread_;
};

std::unique_ptr<SimSession> session_with(const Master& master) {
  auto session = remote_session(master.endpoint(), std::nullopt);
  EXPECT_TRUE(session) << session.error().message;
  return std::move(*session);
}

TEST(HostileMaster, AnHonestSlotIsUnderstood) {
  const Master master([](proto::StepReply& reply) {
    if (reply.has_placements()) reply.mutable_placements()->mutable_object(0)->set_scale(1.4);
  });
  const auto session = session_with(master);
  const auto placements = session->shuffle(1);
  ASSERT_TRUE(placements) << placements.error().message;
  EXPECT_EQ(placements->scale_of(0), 1.4) << "the size was dropped";
  EXPECT_TRUE(session->get_info(0, 0, true));
  const auto grasp = session->get_quality(0, Pose());
  ASSERT_TRUE(grasp) << grasp.error().message;
  EXPECT_EQ(static_cast<int>(grasp->joints.size()), master.what().hand.joint_size());
}

TEST(HostileMaster, JointsAndLinksThatTheHandDoesNotHaveAreRefused) {
  const std::pair<const char*, Twist> cases[] = {
      {"joints",
       [](proto::StepReply& reply) {
         for (int i = 0; i < 100000; ++i) reply.mutable_grasp()->add_joint(1);
       }},
      {"joints", [](proto::StepReply& reply) { reply.mutable_grasp()->clear_joint(); }},
      {"link", [](proto::StepReply& reply) { reply.mutable_grasp()->add_contact()->set_link(1000000); }},
      {"link", [](proto::StepReply& reply) { reply.mutable_grasp()->add_contact()->set_link(4294967295u); }},
  };
  for (const auto& [says, twist] : cases) {
    const Master master(twist);
    const auto grasp = session_with(master)->get_quality(0, Pose());
    ASSERT_FALSE(grasp) << says;
    EXPECT_THAT(grasp.error().message, HasSubstr(says));
  }
}

TEST(HostileMaster, ViewsThatTheCameraCannotHaveAreRefused) {
  const std::tuple<const char*, const char*, Twist> cases[] = {
      {"a sample too many", "depth samples", [](proto::StepReply& r) { r.mutable_info()->add_depth(1); }},
      {"no samples", "depth samples", [](proto::StepReply& r) { r.mutable_info()->clear_depth(); }},
      {"another reply", "depth samples", [](proto::StepReply& r) { r.mutable_grasp(); }},
      {"a feature too many", "features", [](proto::StepReply& r) { r.mutable_info()->add_feature(1); }},
      {"a million features", "features",
       [](proto::StepReply& r) { r.mutable_info()->mutable_feature()->Resize(1000000, 1); }},
      {"a depth of NaN", "depth", [](proto::StepReply& r) { r.mutable_info()->set_depth(7, std::nanf("")); }},
      {"a depth of -1", "depth", [](proto::StepReply& r) { r.mutable_info()->set_depth(0, -1); }},
      {"a depth of 1e30", "depth", [](proto::StepReply& r) { r.mutable_info()->set_depth(0, 1e30F); }},
      {"a click", "no number", [](proto::StepReply& r) { r.mutable_info()->set_click_b(std::nan("")); }},
      {"a box", "no number", [](proto::StepReply& r) { r.mutable_info()->set_box_w(HUGE_VAL); }},
      {"a point", "no number",
       [](proto::StepReply& r) { r.mutable_info()->mutable_point()->set_z(std::nan("")); }},
      {"an anchor", "no number",
       [](proto::StepReply& r) { r.mutable_info()->mutable_anchor()->set_x(-HUGE_VAL); }},
  };
  for (const auto& [what, says, twist] : cases) {
    const Master master(twist);
    const auto info = session_with(master)->get_info(0, 0, true);
    ASSERT_FALSE(info) << what;
    EXPECT_EQ(info.error().code, ErrorCode::kInvalid) << what;
    EXPECT_THAT(info.error().message, HasSubstr(says)) << what;
  }
}

TEST(HostileMaster, FeaturesAreTakenAsTheCameraHasThemAndAsNumbers) {
  for (const float value : {0.25F, std::nanf("")}) {
    const Master master(
        [value](proto::StepReply& reply) {
          for (int i = 0; i < 5; ++i) reply.mutable_info()->add_feature(value);
        },
        {proto::CENTROID, proto::AXIS});
    const auto info = session_with(master)->get_info(0, 0, true);
    if (std::isnan(value)) {
      EXPECT_FALSE(info);
      continue;
    }
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->features, std::vector<float>(5, value));
  }
}

TEST(HostileMaster, MeasurementsThatAreNoNumbersAreRefused) {
  const double nan = std::nan("");
  const std::pair<const char*, std::function<void(proto::GraspReport&)>> cases[] = {
      {"quality", [&](proto::GraspReport& g) { g.mutable_measurement()->set_quality(nan); }},
      {"theta", [&](proto::GraspReport& g) { g.mutable_measurement()->set_theta(HUGE_VAL); }},
      {"p", [&](proto::GraspReport& g) { g.mutable_measurement()->mutable_p()->set_y(nan); }},
      {"joint", [&](proto::GraspReport& g) { g.set_joint(0, nan); }},
      {"contact point", [&](proto::GraspReport& g) { g.add_contact()->mutable_point()->set_x(nan); }},
      {"contact gap", [&](proto::GraspReport& g) { g.add_contact()->set_gap(nan); }},
      {"palm", [&](proto::GraspReport& g) { g.mutable_palm()->mutable_position()->set_x(nan); }},
  };
  for (const auto& [what, twist] : cases) {
    const Master master([&twist = twist](proto::StepReply& reply) { twist(*reply.mutable_grasp()); });
    const auto grasp = session_with(master)->get_quality(0, Pose());
    ASSERT_FALSE(grasp) << what;
    EXPECT_THAT(grasp.error().message, HasSubstr("no number")) << what;
  }
}

TEST(HostileMaster, PlacesThatAreNoneAreRefused) {
  for (const double scale : {0.0, -1.0, 1e300, std::nan("")}) {
    const Master master([scale](proto::StepReply& reply) {
      reply.mutable_placements()->mutable_object(0)->set_scale(scale);
    });
    EXPECT_FALSE(session_with(master)->shuffle(1)) << scale;
  }
  const Master master([](proto::StepReply& reply) {
    reply.mutable_placements()->mutable_object(0)->mutable_pose()->mutable_position()->set_x(std::nan(""));
  });
  EXPECT_FALSE(session_with(master)->shuffle(1));
}

TEST(HostileMaster, MessagesThatNobodyAskedForBuyNoTime) {
  const Master master([](proto::StepReply&) {}, {}, true);
  auto client = StepClient::connect(master.endpoint(), std::nullopt);
  ASSERT_TRUE(client) << client.error().message;
  proto::StepRequest request;
  request.mutable_shuffle()->set_seed(1);
  const auto begin = std::chrono::steady_clock::now();
  const auto reply = client->ask(request, 0.5);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().code, ErrorCode::kUnavailable);
  EXPECT_LT(took.count(), 20) << "each of them began the wait anew";
}

}  // namespace
}  // namespace evograsp::cli

// What a worker makes of a master's Welcome, and of memory and threads that are not there.
#include "worker/session.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <new>
#include <optional>
#include <sstream>

#include "assets/assets.h"
#include "assets/experiment.h"
#include "common/sanitized.h"
#include "common/socket.h"
#include "worker/slots.h"

namespace evograsp::worker {
namespace {

constexpr SessionStamp kStamp{7, 1};

// A master made by hand, and a session that turns when told to.
class Greeted : public ::testing::Test {
 protected:
  Greeted() : router_(*make_router(context_, {})) {
    spdlog::set_level(spdlog::level::off);
    options_.connect = *evograsp::bind(router_, "inproc://greeted");
    options_.slots = 1;
    options_.identity = "tested";
    session_.emplace(context_, options_, wakeup_, order_);
  }

  void say(const proto::Envelope& envelope) { send(router_, peer_, envelope); }
  void welcome(const std::string& fingerprint, const std::string& object) {
    proto::Envelope envelope = make_envelope(kStamp);
    proto::Welcome& welcome = *envelope.mutable_welcome();
    welcome.set_silence_seconds(60);
    welcome.set_heartbeat_seconds(60);
    welcome.mutable_experiment()->set_fingerprint(fingerprint);
    if (!object.empty()) welcome.mutable_experiment()->add_object_id(object);
    say(envelope);
  }
  // A few turns; how many messages of a kind they brought.
  int heard(proto::Envelope::BodyCase kind, int turns = 5) {
    int count = 0;
    for (int i = 0; i < turns && !session_->over(); ++i) {
      const Status status = session_->turn();
      EXPECT_TRUE(status) << status.error().message;
      google::protobuf::Arena arena;
      Received received;
      while (receive(router_, true, arena, received)) {
        peer_ = received.peer;
        count += received.envelope != nullptr && received.envelope->body_case() == kind;
      }
    }
    return count;
  }

  // Turns until such a message has come.
  bool await(proto::Envelope::BodyCase kind) {
    for (int i = 0; i < 1000 && !session_->over(); ++i)
      if (heard(kind, 1) > 0) return true;
    return false;
  }

  zmq::context_t context_;
  zmq::socket_t router_;
  WorkerOptions options_;
  const std::shared_ptr<Wakeup> wakeup_ = std::make_shared<Wakeup>();
  std::atomic<int> order_{Session::kServe};
  std::optional<Session> session_;
  std::string peer_;
};

TEST_F(Greeted, OneWelcomeAConnectionIsActedOn) {
  ASSERT_TRUE(await(proto::Envelope::kHello));
  welcome("first", "");
  ASSERT_TRUE(await(proto::Envelope::kReady));
  for (int i = 0; i < 3; ++i) welcome("second", "");
  EXPECT_EQ(heard(proto::Envelope::kReady), 0);
  welcome("third", "an object");
  EXPECT_EQ(heard(proto::Envelope::kAssetRequest), 0);
  EXPECT_FALSE(session_->over());
}

TEST_F(Greeted, WelcomesDoNotPutOffTheEndOfADrain) {
  ASSERT_TRUE(await(proto::Envelope::kHello));
  options_.drain_seconds = 0.2;
  welcome("first", "");
  ASSERT_TRUE(await(proto::Envelope::kReady));
  proto::Envelope task = make_envelope(kStamp);
  task.mutable_task()->set_id(1);
  task.mutable_task()->set_noop_seconds(2);
  task.mutable_task()->add_network(1);
  task.mutable_task()->add_trial();
  task.mutable_task()->set_trials(1);
  task.add_attachment("network");
  say(task);
  ASSERT_TRUE(await(proto::Envelope::kStarted));
  order_ = Session::kDrain;
  const auto began = std::chrono::steady_clock::now();
  int drains = 0;
  while (!session_->over() && std::chrono::steady_clock::now() - began < std::chrono::seconds(1)) {
    drains += heard(proto::Envelope::kDrain, 1);
    welcome("first", "");
  }
  EXPECT_TRUE(session_->over()) << "still there after five times its drain seconds";
  EXPECT_EQ(drains, 1);
}

// Without a fingerprint nobody knows what would be simulated: no Ready without a simulator.
TEST_F(Greeted, AnExperimentWithoutFingerprintIsRefused) {
  ASSERT_TRUE(await(proto::Envelope::kHello));
  welcome("", "an object");
  EXPECT_EQ(heard(proto::Envelope::kReady), 0);
  EXPECT_TRUE(session_->over());
}

// A mistyped host is the operator's to find: it is said, once.
TEST_F(Greeted, AWorkerThatFindsNoMasterSaysSoOnce) {
  std::ostringstream said;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  options_.alive_file = "/nowhere/alive";
  const auto began = std::chrono::steady_clock::now();
  const auto turn_for = [&](std::chrono::milliseconds time) {
    while (std::chrono::steady_clock::now() - began < time) heard(proto::Envelope::kHello, 1);
    return said.str();
  };
  const auto times = [](const std::string& text, const std::string& what) {
    int count = 0;
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  EXPECT_EQ(times(turn_for(std::chrono::milliseconds(1500)), "no master"), 0);
  const std::string all = turn_for(std::chrono::milliseconds(6300));
  spdlog::set_default_logger(before);
  EXPECT_EQ(times(all, "no master answers at inproc://greeted: still looking"), 1) << all;
  EXPECT_EQ(times(all, "--alive-file /nowhere/alive: cannot be written: No such file"), 1) << all;
}

TEST_F(Greeted, MoreObjectsThanASceneHoldsAreRefused) {
  Loader loader;
  proto::Experiment experiment;
  for (int i = 0; i < 257; ++i) experiment.add_object_id(std::to_string(i));
  experiment.set_fingerprint(assets::experiment_fingerprint(experiment));
  const Status begun = loader.begin(experiment);
  ASSERT_FALSE(begun);
  EXPECT_NE(begun.error().message.find("257 objects, more than 256"), std::string::npos);
}

// What a slot throws must not end the process.
TEST(Slots, AJobThatThrowsLeavesItsSlotAtWork) {
  SlotPool pool(1, std::make_shared<Wakeup>());
  Job failing;
  failing.errand = [] { throw std::bad_alloc(); };
  pool.push(std::move(failing));
  std::atomic<bool> done{false};
  Job after;
  after.errand = [&done] { done = true; };
  pool.push(std::move(after));
  for (int i = 0; i < 1000 && !done; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(done);
}

#ifndef EVOGRASP_SANITIZED
// 4,096 stacks do not fit into the address space that is left: in a process of its own.
TEST(SlotsDeathTest, TooFewThreadsAreAnErrorThatSaysWhatToDo) {
  const auto starve = [] {
    rlimit limit{};
    limit.rlim_cur = limit.rlim_max = std::size_t{1} << 30;
    setrlimit(RLIMIT_AS, &limit);
    WorkerOptions options;
    options.slots = 4096;
    const auto worker = Worker::create(options);
    const Status status = (*worker)->run();
    std::fprintf(stderr, "said: %s\n", status ? "nothing" : status.error().message.c_str());
    std::_Exit(status ? 0 : static_cast<int>(status.error().code));
  };
  EXPECT_EXIT(starve(), ::testing::ExitedWithCode(2), "said: only [0-9]+ of 4096 slots: give fewer --slots");
}
#endif

}  // namespace
}  // namespace evograsp::worker

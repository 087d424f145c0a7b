// Workers that live and do not work, and honest ones that are away for a moment: the run goes on, and nobody
// is believed meanwhile.
#include <gtest/gtest.h>

#include "server/dispatcher.h"
#include "tests/server/cluster.h"
#include "tests/server/raw_peer.h"

namespace evograsp {
namespace {

using testing::CountingSink;
using testing::eventually;
using testing::give_noop_work;
using testing::Process;
using testing::RawPeer;
using testing::TempDir;

class Deadlines : public ::testing::Test {
 protected:
  void start(double audit_share, double task_deadline = 0.3) {
    server::DispatcherOptions options = testing::noop_options();
    options.audit_share = audit_share;
    options.silence_seconds = 2;
    options.scheduler.task_deadline = task_deadline;
    dispatcher_ = std::move(*server::Dispatcher::create(context_, std::move(options), sink_));
    endpoint_ = dispatcher_->endpoints()[0];
  }
  std::unique_ptr<Process> worker(const std::string& name, const std::string& fault = {}) {
    auto process = std::make_unique<Process>(
        "evograsp-worker-faulty",
        std::vector<std::string>{"--connect", endpoint_, "--identity", name, "--slots", "1"},
        dir_.path() / name, std::vector<std::string>{"EVOGRASP_FAULT=" + fault});
    EXPECT_TRUE(eventually([&] { return process->log().find("welcome") != std::string::npos; }));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // its Ready is on its way
    return process;
  }
  // It lives, and does nothing else, until `enough` or the time is up.
  static bool beats_until(RawPeer& peer, double seconds, const std::function<bool()>& enough) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!enough() && std::chrono::steady_clock::now() < end) {
      proto::Envelope alive = make_envelope(peer.stamp());
      alive.mutable_heartbeat();
      peer.send(alive);
      peer.next(0.05);
    }
    return enough();
  }
  bool finished() const { return sink_.finished_times() > 0; }

  zmq::context_t context_{1};
  TempDir dir_;
  CountingSink sink_;
  std::unique_ptr<server::Dispatcher> dispatcher_;
  std::string endpoint_;
};

TEST_F(Deadlines, AWorkerThatHoldsAuditsAndStartsNoneHoldsUpNothing) {
  start(1);
  RawPeer silent(context_, endpoint_);
  ASSERT_TRUE(silent.join("silent"));
  const auto honest = worker("honest");
  give_noop_work(*dispatcher_, 60, 1, 0);
  EXPECT_TRUE(beats_until(silent, 15, [&] { return finished(); })) << sink_.evaluations().size() << " of 60";
  testing::expect_once(sink_, 60);
  EXPECT_EQ(sink_.events("idle"), 1);
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().tasks_done > 0; }));
  EXPECT_EQ(dispatcher_->view().scheduler.strikes, 0U) << "what nobody started is to blame for nothing";
}

// It is told not to, but comes back each time.
TEST_F(Deadlines, NorWhenItComesBackForMore) {
  start(1);
  auto silent = std::make_unique<RawPeer>(context_, endpoint_);
  ASSERT_TRUE(silent->join("silent"));
  const auto honest = worker("honest");
  give_noop_work(*dispatcher_, 60, 1, 0);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  for (int times = 0; !finished() && std::chrono::steady_clock::now() < end; ++times) {
    beats_until(*silent, 5, [&] { return finished() || sink_.events("idle") > times; });
    silent = std::make_unique<RawPeer>(context_, endpoint_);
    silent->join("silent");
  }
  EXPECT_TRUE(finished()) << sink_.evaluations().size() << " of 60";
  testing::expect_once(sink_, 60);
}

TEST_F(Deadlines, AWorkerThatHoldsASuspectAndDoesNotStartItHoldsUpNothing) {
  start(0);
  RawPeer silent(context_, endpoint_);
  {
    RawPeer dying(context_, endpoint_);
    ASSERT_TRUE(dying.join("dying"));
    give_noop_work(*dispatcher_, 1, 1, 0);
    const auto task = dying.next();
    ASSERT_TRUE(task && task->has_task());
    proto::Envelope started = make_envelope(dying.stamp());
    started.mutable_started()->set_id(task->task().id());
    started.mutable_started()->set_attempt(task->task().attempt());
    dying.send(started);
    proto::Envelope question = make_envelope(dying.stamp());
    question.mutable_asset_request()->set_id("none");
    dying.send(question);
    ASSERT_TRUE(dying.next()) << "what was said before it dies has been heard";
  }
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_lost") == 1; }));
  ASSERT_TRUE(silent.join("silent"));
  const auto held = silent.next();
  ASSERT_TRUE(held && held->has_task() && held->task().suspect());
  const auto honest = worker("honest");
  EXPECT_TRUE(beats_until(silent, 15, [&] { return finished(); }));
  testing::expect_once(sink_, 1);
  EXPECT_TRUE(sink_.poison().empty());
}

// As when a link is new before the loss of the old one was noticed; then it loads for longer than those who
// are lost are waited for.
TEST_F(Deadlines, ALiarIsNotBelievedWhileItsAuditorComesBackAndLoads) {
  start(1, 30);
  RawPeer honest(context_, endpoint_);
  ASSERT_TRUE(honest.join("honest"));
  const auto liar = worker("liar", "lie");
  give_noop_work(*dispatcher_, 20, 2, 0);
  ASSERT_TRUE(eventually([&] { return dispatcher_->view().tasks_done > 0; }));
  RawPeer again(context_, endpoint_);
  again.send(again.hello("honest"));
  const auto welcome = again.next();
  ASSERT_TRUE(welcome && welcome->has_welcome());
  const SessionStamp stamp{welcome->run(), welcome->epoch()};
  for (int i = 0; i < 30; ++i) {  // 3 s
    proto::Envelope alive = make_envelope(stamp);
    alive.mutable_heartbeat();
    again.send(alive);
    again.next(0.1);
  }
  EXPECT_EQ(sink_.events("unaudited"), 0) << "an auditor is connected, and loads";
  EXPECT_TRUE(sink_.evaluations().empty()) << "a liar alone was believed";
  const auto second = worker("second"), third = worker("third");
  ASSERT_TRUE(eventually([&] { return finished() && sink_.events("quarantine") == 1; }));
  EXPECT_TRUE(sink_.all_zero_quality()) << "a lie was believed";
}

TEST_F(Deadlines, WhoIsSentAwayForAWrongWordIsWaitedForAsWell) {
  start(1, 30);
  RawPeer honest(context_, endpoint_);
  ASSERT_TRUE(honest.join("honest"));
  const auto liar = worker("liar", "lie");
  give_noop_work(*dispatcher_, 20, 2, 0);
  ASSERT_TRUE(eventually([&] { return dispatcher_->view().tasks_done > 0; }));
  proto::Envelope wrong = make_envelope(honest.stamp());
  wrong.mutable_welcome();
  honest.send(wrong);
  ASSERT_TRUE(eventually([&] { return sink_.events("malformed") == 1; }));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_EQ(sink_.events("unaudited"), 0) << "it may be back at once";
  EXPECT_TRUE(eventually([&] { return finished(); }, 10)) << "but is not waited for for long";
}

TEST_F(Deadlines, WhoSaysGoodbyeIsNotWaitedFor) {
  start(1, 30);
  RawPeer leaving(context_, endpoint_);
  ASSERT_TRUE(leaving.join("leaving"));
  const auto alone = worker("alone");
  give_noop_work(*dispatcher_, 20, 2, 0);
  ASSERT_TRUE(eventually([&] { return dispatcher_->view().tasks_done > 0; }));
  proto::Envelope goodbye = make_envelope(leaving.stamp());
  goodbye.mutable_goodbye()->set_reason("enough");
  leaving.send(goodbye);
  EXPECT_TRUE(eventually([&] { return finished(); }, 1.5)) << "it was waited for";
}

TEST_F(Deadlines, ABeatThatNobodyAskedForSaysNothingOfTheWay) {
  server::DispatcherOptions options = testing::noop_options();
  options.heartbeat_seconds = 30;  // so that nobody is asked
  options.silence_seconds = 60;
  dispatcher_ = std::move(*server::Dispatcher::create(context_, std::move(options), sink_));
  endpoint_ = dispatcher_->endpoints()[0];
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  RawPeer peer(context_, endpoint_);
  ASSERT_TRUE(peer.join("unasked"));
  proto::Envelope beat = make_envelope(peer.stamp());
  beat.mutable_heartbeat();
  peer.send(beat);
  proto::Envelope question = make_envelope(peer.stamp());
  question.mutable_asset_request()->set_id("none");
  peer.send(question);
  ASSERT_TRUE(peer.next()) << "what was said before the answer has been heard";
  ASSERT_TRUE(eventually([&] { return dispatcher_->view().workers.size() == 1; }));
  EXPECT_EQ(dispatcher_->view().workers[0].round_trip, 0) << "taken for an echo";
  give_noop_work(*dispatcher_, 5000, 1, 0, 100000);
  ASSERT_TRUE(eventually([&] { return dispatcher_->view().workers[0].outstanding > 0; }));
  EXPECT_EQ(dispatcher_->view().workers[0].outstanding, 2U) << "the least credit";
}

}  // namespace
}  // namespace evograsp

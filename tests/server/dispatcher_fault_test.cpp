// Peers that break the rules, vanish, freeze or come twice: the work gets done, once, and the master stays.
#include <gtest/gtest.h>

#include "common/random.h"
#include "server/dispatcher.h"
#include "tests/server/cluster.h"
#include "tests/server/raw_peer.h"

namespace evograsp {
namespace {

using testing::CountingSink;
using testing::eventually;
using testing::give_noop_work;
using testing::noop_options;
using testing::Process;
using testing::RawPeer;
using testing::TempDir;
using testing::WorkerThread;

int open_descriptors() {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}
int threads() {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) ++count;
  return count;
}

class DispatcherFaults : public ::testing::Test {
 protected:
  void start(server::DispatcherOptions options = noop_options()) {
    dispatcher_ = std::move(*server::Dispatcher::create(context_, std::move(options), sink_));
    endpoint_ = dispatcher_->endpoints()[0];
  }

  // Until the work is done.
  void answer_all(RawPeer& peer) {
    for (int answered = 0; sink_.finished_times() == 0 && answered < 20; ++answered) {
      const auto task = peer.next();
      ASSERT_TRUE(task);
      if (task->has_task()) peer.send(peer.result_of(task->task()));
      eventually([&] { return sink_.finished_times() > 0; }, 0.05);
    }
  }

  zmq::context_t context_{1};
  CountingSink sink_;
  std::unique_ptr<server::Dispatcher> dispatcher_;
  std::string endpoint_;
};

TEST_F(DispatcherFaults, GarbageFromStrangersDoesNotHoldUpTheWork) {
  start();
  RawPeer stranger(context_, endpoint_);
  Random random(1, Purpose::kTestHarness);
  for (int i = 0; i < 2000; ++i) {
    std::string bytes(random.below(200), '\0');
    for (char& b : bytes) b = static_cast<char>(random.next());
    stranger.send_bytes(bytes);
  }
  WorkerThread worker(&context_, endpoint_, 2);
  give_noop_work(*dispatcher_, 500, 5, 0.0001);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  testing::expect_once(sink_, 500);
  EXPECT_GT(sink_.events("malformed"), 0);
  EXPECT_LT(sink_.events("malformed"), 100) << "a stranger fills the log";
}

TEST_F(DispatcherFaults, AnotherProtocolVersionIsRefusedWithTheReason) {
  start();
  RawPeer old(context_, endpoint_);
  proto::Envelope hello = old.hello("old");
  hello.set_protocol(kProtocolVersion + 1);
  old.send(hello);
  const auto answer = old.next();
  ASSERT_TRUE(answer && answer->has_refusal());
  EXPECT_FALSE(answer->refusal().retry());
  EXPECT_NE(answer->refusal().reason().find("protocol version " + std::to_string(kProtocolVersion + 1)),
            std::string::npos)
      << answer->refusal().reason();
  EXPECT_EQ(sink_.events("malformed"), 1);
  EXPECT_NE(sink_.event_text("malformed").find("the hello of worker old in protocol version"),
            std::string::npos)
      << sink_.event_text("malformed");
}

TEST_F(DispatcherFaults, AnotherBuildIsRefusedOnBothSides) {
  start();
  RawPeer other(context_, endpoint_);
  proto::Envelope hello = other.hello("other");
  hello.mutable_hello()->set_build("9.9");
  other.send(hello);
  const auto answer = other.next();
  ASSERT_TRUE(answer && answer->has_refusal());
  EXPECT_FALSE(answer->refusal().retry());
  EXPECT_NE(answer->refusal().reason().find("9.9"), std::string::npos);
  EXPECT_EQ(sink_.events("refused"), 1);
}

TEST_F(DispatcherFaults, AnotherExperimentIsRefused) {
  start();
  RawPeer peer(context_, endpoint_);
  peer.send(peer.hello("peer"));
  const auto welcome = peer.next();
  ASSERT_TRUE(welcome && welcome->has_welcome());
  proto::Envelope ready = make_envelope({welcome->run(), welcome->epoch()});
  ready.mutable_ready()->set_fingerprint("another");
  peer.send(ready);
  const auto answer = peer.next();
  ASSERT_TRUE(answer && answer->has_refusal());
  EXPECT_NE(answer->refusal().reason().find("fingerprint"), std::string::npos);
  EXPECT_EQ(sink_.events("refused"), 1);
  EXPECT_NE(sink_.event_text("refused").find(
                "worker peer: the worker's simulator is not the experiment's: fingerprint "
                "another instead of none"),
            std::string::npos)
      << sink_.event_text("refused");
}

// As of a worker that has outlived a master and speaks to its successor.
TEST_F(DispatcherFaults, AResultFromAnotherEpochOrRunIsNobodys) {
  server::DispatcherOptions options = noop_options();
  options.stamp = {7, 4};
  start(std::move(options));
  RawPeer peer(context_, endpoint_);
  ASSERT_TRUE(peer.join("old hand"));
  give_noop_work(*dispatcher_, 1, 2, 0);
  const auto task = peer.next();
  ASSERT_TRUE(task && task->has_task());
  proto::Envelope result = peer.result_of(task->task());
  for (const SessionStamp& stamp : {SessionStamp{7, 3}, SessionStamp{7, 5}, SessionStamp{8, 4}}) {
    result.set_run(stamp.run);
    result.set_epoch(stamp.epoch);
    for (proto::Measurement& m : *result.mutable_result()->mutable_measurement()) m.set_quality(1);
    peer.send(result);
  }
  proto::Envelope question = make_envelope(peer.stamp());
  question.mutable_asset_request()->set_id("none");
  peer.send(question);
  const auto answer = peer.next();
  ASSERT_TRUE(answer && answer->has_asset_reply()) << "what was said before has been heard";
  EXPECT_TRUE(sink_.evaluations().empty());
  peer.send(peer.result_of(task->task()));
  EXPECT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  testing::expect_once(sink_, 1);
  EXPECT_TRUE(sink_.all_zero_quality());
}

TEST_F(DispatcherFaults, WithoutAHelloNothingIsBelieved) {
  start();
  RawPeer peer(context_, endpoint_);
  proto::Envelope result = make_envelope({7, 1});
  result.mutable_result()->set_id(1);
  peer.send(result);
  const auto answer = peer.next();
  ASSERT_TRUE(answer && answer->has_refusal());
  EXPECT_TRUE(answer->refusal().retry()) << "a worker that outlived its master must say hello again";
}

TEST_F(DispatcherFaults, AnOversizedFrameCostsTheConnectionOnly) {
  start(noop_options(4096));
  RawPeer peer(context_, endpoint_);
  ASSERT_TRUE(peer.join("large"));
  peer.watch();
  peer.send_bytes(std::string(100000, 'x'));
  EXPECT_TRUE(eventually([&] { return peer.ended(); })) << "the frame was taken";
  WorkerThread worker(&context_, endpoint_, 1);
  give_noop_work(*dispatcher_, 50, 2, 0.0001);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  testing::expect_once(sink_, 50);
  EXPECT_EQ(sink_.events("malformed"), 0) << "the frame reached the program";
}

TEST_F(DispatcherFaults, AResultOfTheWrongSizeCostsTheSession) {
  start();
  RawPeer peer(context_, endpoint_);
  ASSERT_TRUE(peer.join("short"));
  give_noop_work(*dispatcher_, 2, 3, 0);
  const auto task = peer.next();
  ASSERT_TRUE(task && task->has_task());
  proto::Envelope result = peer.result_of(task->task());
  result.mutable_result()->mutable_measurement()->RemoveLast();
  peer.send(result);
  bool refused = false;
  for (int i = 0; i < 5 && !refused; ++i) {
    const auto answer = peer.next();
    refused = answer && answer->has_refusal();
  }
  EXPECT_TRUE(refused);
  WorkerThread worker(&context_, endpoint_, 1);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  testing::expect_once(sink_, 2);
}

TEST_F(DispatcherFaults, AResultCountsOnceHoweverOftenItComes) {
  start();
  RawPeer peer(context_, endpoint_);
  ASSERT_TRUE(peer.join("eager"));
  give_noop_work(*dispatcher_, 3, 2, 0, 1 << 19);
  while (sink_.finished_times() == 0) {
    const auto task = peer.next();
    ASSERT_TRUE(task);
    if (!task->has_task()) continue;
    for (int i = 0; i < 3; ++i) peer.send(peer.result_of(task->task()));
    eventually([&] { return sink_.finished_times() > 0; }, 0.05);
  }
  testing::expect_once(sink_, 3);
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().scheduler.late >= 6; }));
}

TEST_F(DispatcherFaults, ASecondProcessWithTheSameIdentityMustWait) {
  start();
  RawPeer first(context_, endpoint_), second(context_, endpoint_);
  ASSERT_TRUE(first.join("twin"));
  second.send(second.hello("twin", 2));
  const auto answer = second.next();
  ASSERT_TRUE(answer && answer->has_refusal());
  EXPECT_TRUE(answer->refusal().retry());
  EXPECT_NE(answer->refusal().reason().find("in use"), std::string::npos);
}

TEST_F(DispatcherFaults, AConnectionThatTakesAnOlderSessionsNameIsOneSession) {
  start();
  RawPeer other(context_, endpoint_), turncoat(context_, endpoint_);
  ASSERT_TRUE(other.join("taken"));
  ASSERT_TRUE(turncoat.join("own"));
  ASSERT_TRUE(turncoat.join("taken"));
  give_noop_work(*dispatcher_, 4, 1, 0);
  answer_all(turncoat);
  testing::expect_once(sink_, 4);
}

TEST_F(DispatcherFaults, AConnectionThatTakesAYoungerSessionsNameIsOneSession) {
  start();
  RawPeer other(context_, endpoint_), turncoat(context_, endpoint_);
  ASSERT_TRUE(turncoat.join("own"));
  ASSERT_TRUE(other.join("taken"));
  ASSERT_TRUE(turncoat.join("taken"));
  give_noop_work(*dispatcher_, 4, 1, 0);
  answer_all(turncoat);
  testing::expect_once(sink_, 4);
}

// A worker that starts while the run ends would wait for work that never comes.
TEST_F(DispatcherFaults, AWorkerThatComesWhenTheRunIsOverIsToldSo) {
  start();
  RawPeer early(context_, endpoint_), late(context_, endpoint_);
  ASSERT_TRUE(early.join("early"));
  dispatcher_->dismiss("the run is finished");
  for (RawPeer* peer : {&early, &late}) {
    ASSERT_TRUE(peer == &early || late.join("late"));
    const auto told = peer->next();
    ASSERT_TRUE(told && told->has_drain());
    EXPECT_EQ(told->drain().reason(), "the run is finished");
  }
}

TEST_F(DispatcherFaults, AProcessThatComesBackReplacesItsOldSession) {
  start();
  RawPeer first(context_, endpoint_);
  ASSERT_TRUE(first.join("phoenix"));
  give_noop_work(*dispatcher_, 4, 1, 0);
  ASSERT_TRUE(first.next());  // holds work now
  RawPeer again(context_, endpoint_);
  ASSERT_TRUE(again.join("phoenix"));
  answer_all(again);
  testing::expect_once(sink_, 4);
}

TEST_F(DispatcherFaults, AKilledWorkerIsNoticedLongBeforeAnyHeartbeat) {
  server::DispatcherOptions options = noop_options();
  options.silence_seconds = 30;
  start(std::move(options));
  TempDir dir;
  Process victim("evograsp-worker", {"--connect", endpoint_, "--slots", "1"}, dir.path() / "victim");
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_joined") == 1; })) << victim.log();
  victim.finish(SIGKILL);
  const auto killed = std::chrono::steady_clock::now();
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_lost") == 1; }, 5));
  EXPECT_LT(std::chrono::steady_clock::now() - killed, std::chrono::seconds(2));
}

TEST_F(DispatcherFaults, AFrozenWorkersTasksGoToOthers) {
  start();
  TempDir dir;
  Process frozen("evograsp-worker", {"--connect", endpoint_, "--slots", "2"}, dir.path() / "frozen");
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_joined") == 1; })) << frozen.log();
  give_noop_work(*dispatcher_, 200, 2, 0.002);
  ASSERT_TRUE(eventually([&] { return dispatcher_->view().scheduler.tasks > 0; }));
  frozen.signal(SIGSTOP);
  WorkerThread worker(&context_, endpoint_, 2);
  EXPECT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  testing::expect_once(sink_, 200);
  EXPECT_TRUE(eventually([&] { return sink_.events("worker_lost") == 1; }));
  frozen.signal(SIGCONT);  // its late results are nobody's; it says hello again
  EXPECT_TRUE(eventually([&] { return sink_.events("worker_joined") >= 3; })) << frozen.log();
}

TEST_F(DispatcherFaults, ADrainedWorkerHandsBackAndIsNotBlamed) {
  start();
  TempDir dir;
  Process leaving("evograsp-worker", {"--connect", endpoint_, "--slots", "1"}, dir.path() / "leaving");
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_joined") == 1; })) << leaving.log();
  give_noop_work(*dispatcher_, 100, 1, 0.01);
  ASSERT_TRUE(eventually([&] { return sink_.evaluations().size() > 2; }));
  leaving.signal(SIGTERM);
  EXPECT_EQ(leaving.finish(), 0) << leaving.log();
  WorkerThread worker(&context_, endpoint_, 2);
  EXPECT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  testing::expect_once(sink_, 100);
  EXPECT_TRUE(eventually([&] { return sink_.events("worker_left") == 1; }));
  EXPECT_EQ(dispatcher_->view().scheduler.strikes, 0U);
}

TEST_F(DispatcherFaults, ATaskPastItsDeadlineGoesElsewhereAndItsWorkerIsSentAway) {
  server::DispatcherOptions options = noop_options();
  options.scheduler.task_deadline = 0.3;
  start(std::move(options));
  RawPeer hung(context_, endpoint_);
  ASSERT_TRUE(hung.join("hung"));
  give_noop_work(*dispatcher_, 1, 1, 0);
  const auto task = hung.next();
  ASSERT_TRUE(task && task->has_task());
  proto::Envelope started = make_envelope(hung.stamp());
  started.mutable_started()->set_id(task->task().id());
  started.mutable_started()->set_attempt(task->task().attempt());
  hung.send(started);
  // A live worker whose slot hangs still answers heartbeats.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  bool sent_away = false;
  while (!sent_away && std::chrono::steady_clock::now() < end) {
    proto::Envelope alive = make_envelope(hung.stamp());
    alive.mutable_heartbeat();
    hung.send(alive);
    const auto answer = hung.next(0.05);
    sent_away = answer && answer->has_refusal();
  }
  EXPECT_TRUE(sent_away);
  EXPECT_EQ(sink_.events("hung"), 1);
  WorkerThread worker(&context_, endpoint_, 1);
  EXPECT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
}

TEST_F(DispatcherFaults, ManyReconnectsLeakNeitherDescriptorsNorThreads) {
  start();
  const auto knock = [&](int i) {
    RawPeer peer(context_, endpoint_);
    ASSERT_TRUE(peer.join("worker-" + std::to_string(i)));
  };
  knock(-1);
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_lost") == 1; }));
  const int descriptors = open_descriptors(), running = threads();
  for (int i = 0; i < 300; ++i) knock(i);
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_lost") == 301; }));
  EXPECT_TRUE(eventually([&] { return open_descriptors() <= descriptors + 2; })) << open_descriptors();
  EXPECT_EQ(threads(), running);
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().workers.empty(); }));
}

// Another name over another connection each time: who comes and goes has a line while a person could read it.
TEST_F(DispatcherFaults, ACrowdThatComesAndGoesDoesNotFillTheLog) {
  start();
  for (int i = 0; i < 1000; ++i) {
    RawPeer peer(context_, endpoint_);
    peer.send(peer.hello("somebody-" + std::to_string(i)));
    ASSERT_TRUE(peer.next());
  }
  EXPECT_TRUE(eventually([&] { return sink_.events("unlisted") > 0; })) << "what is left out must be said";
  EXPECT_LT(sink_.events("worker_joined") + sink_.events("worker_lost"), 1300);
  EXPECT_GT(sink_.events("worker_joined"), 400);
}

}  // namespace
}  // namespace evograsp

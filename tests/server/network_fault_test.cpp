// Links that are cut, slow or late, processes that get no processor, clocks that are wrong: how soon it is
// noticed, how soon work goes on, and that the bytes stay the same. Times are printed, and the best of a few
// attempts must be what docs/GUARANTEES.md promises.
#include <gtest/gtest.h>

#include <cstdlib>

#include "server/dispatcher.h"
#include "tests/server/raw_peer.h"
#include "tests/server/real_run.h"
#include "tests/server/relay.h"

namespace evograsp {
namespace {

using testing::CountingSink;
using testing::eventually;
using testing::give_noop_work;
using testing::Process;
using testing::RealRun;
using testing::Relay;
using testing::TempDir;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr double kNever = 1e9;

// Seconds from now until the condition holds.
double seconds_until(const std::function<bool()>& condition) {
  const auto start = Clock::now();
  return eventually(condition) ? since(start) : kNever;
}

// A busy machine makes a measurement late, never early: the least of a few, at most until one is within the
// promise. Asserted, and printed.
void expect_within(double promise, const char* what, const std::function<double()>& measure) {
  constexpr int kAttempts = 4;
  double best = kNever;
  for (int attempt = 0; attempt < kAttempts && best > promise; ++attempt) {
    const double seconds = measure();
    std::printf("%s after %.3f s\n", what, seconds);
    best = std::min(best, seconds);
  }
  EXPECT_LE(best, promise) << what;
}

// The product's own limits: heartbeats every 0.5 s, silence 1.5 s.
class Network : public ::testing::Test {
 protected:
  void start(double task_deadline = 30, double task_seconds = 0.05) {
    server::DispatcherOptions options = testing::noop_options(64 << 20);
    options.heartbeat_seconds = 0.5;
    options.silence_seconds = 1.5;
    options.scheduler.task_deadline = task_deadline;
    options.scheduler.task_seconds = task_seconds;
    dispatcher_ = std::move(*server::Dispatcher::create(context_, std::move(options), sink_));
    endpoint_ = dispatcher_->endpoints()[0];
  }
  std::unique_ptr<Process> worker(const std::string& endpoint, const std::string& name,
                                  const std::string& fault = "") {
    auto process = std::make_unique<Process>(
        "evograsp-worker-faulty",
        std::vector<std::string>{"--connect", endpoint, "--slots", "1", "--identity", name},
        dir_.path() / name, std::vector<std::string>{"EVOGRASP_FAULT=" + fault});
    EXPECT_TRUE(eventually([&] { return process->log().find("welcome") != std::string::npos; }))
        << process->log();
    return process;
  }
  std::uint64_t done() { return dispatcher_->view().tasks_done; }
  // Late or busy is not lost. On a network that drops packets (tests/platforms/lossy_test.sh) a greeting may
  // take longer than a worker waits for it; then it connects anew, and only the work counts.
  static bool lossy() { return std::getenv("EVOGRASP_LOSSY") != nullptr; }
  void expect_nobody_lost() {
    if (!lossy()) {
      EXPECT_EQ(sink_.events("worker_lost"), 0) << "late or busy was taken for lost";
    }
  }

  zmq::context_t context_{1};
  TempDir dir_;
  CountingSink sink_;
  std::unique_ptr<server::Dispatcher> dispatcher_;
  std::string endpoint_;
};

TEST_F(Network, AKilledWorkerIsNoticedByItsConnection) {
  int attempt = 0;
  expect_within(0.1, "a killed worker was noticed", [&] {
    start();
    const auto victim = worker(endpoint_, "victim-" + std::to_string(attempt++), "sleep:30");
    give_noop_work(*dispatcher_, 4, 1, 0);
    EXPECT_TRUE(eventually([&] { return dispatcher_->view().scheduler.tasks > 0; }));
    const int lost = sink_.events("worker_lost");
    victim->signal(SIGKILL);
    return seconds_until([&] { return sink_.events("worker_lost") > lost; });
  });
}

TEST_F(Network, ASilentCutIsNoticedAndWorkGoesOnWhenTheLinkIsBack) {
  start();
  Relay relay(endpoint_, {});
  const auto process = worker(relay.endpoint(), "far");
  give_noop_work(*dispatcher_, 100000, 1, 0.005);
  ASSERT_TRUE(eventually([&] { return done() > 3; }));
  expect_within(2, "work went on, the link being back,", [&] {
    const std::size_t said = process->log().size();
    const int lost = sink_.events("worker_lost");
    relay.cut();
    const auto cut = Clock::now();
    EXPECT_LE(seconds_until([&] { return sink_.events("worker_lost") > lost; }), 3);
    std::printf("a silent cut was noticed after %.2f s\n", since(cut));
    EXPECT_TRUE(eventually([&] { return process->log().find("silent", said) != std::string::npos; }));
    std::printf("and by the worker after %.2f s\n", since(cut));
    std::this_thread::sleep_for(std::chrono::seconds(2));
    const std::uint64_t before = done();
    relay.restore();
    return seconds_until([&] { return done() > before; });
  });
}

TEST_F(Network, AMasterThatIsBackIsFoundAgain) {
  start();
  const auto process = worker(endpoint_, "loyal");
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_joined") == 1; }));
  expect_within(2, "work was done, the master being back,", [&] {
    dispatcher_.reset();
    std::this_thread::sleep_for(std::chrono::seconds(3));
    server::DispatcherOptions options = testing::noop_options();
    options.endpoints = {endpoint_};
    const int finished = sink_.finished_times();
    const auto back = Clock::now();
    dispatcher_ = std::move(*server::Dispatcher::create(context_, std::move(options), sink_));
    give_noop_work(*dispatcher_, 10, 1, 0);
    return eventually([&] { return sink_.finished_times() > finished; }) ? since(back) : kNever;
  });
}

TEST_F(Network, AHungEvaluatorIsNoticedAtItsDeadlineAndItsWorkerEnds) {
  constexpr double kDeadline = 0.5;
  int attempt = 0;
  expect_within(0.2, "a hung evaluator was noticed, its deadline being over,", [&] {
    start(kDeadline);
    const auto hung = worker(endpoint_, "hung-" + std::to_string(attempt), "hang:0");
    const int noticed = sink_.events("hung"), finished = sink_.finished_times();
    const auto begun = Clock::now();
    give_noop_work(*dispatcher_, 1, 1, 0);
    const double late = seconds_until([&] { return sink_.events("hung") > noticed; }) - kDeadline;
    EXPECT_EQ(hung->finish(), 6) << "a slot that hangs must not keep the process";
    std::printf("its process ended %.2f s after it had begun to hang\n", since(begun));
    EXPECT_LT(since(begun), 10) << "two seconds of patience with the slot, and no more than it takes to end";
    const auto other = worker(endpoint_, "other-" + std::to_string(attempt++));
    EXPECT_TRUE(eventually([&] { return sink_.finished_times() > finished; }));
    return late;
  });
}

// Tasks of one evaluation each, a tenth of the round trip long: with the least credit, two, the worker would
// idle four fifths of the time.
TEST_F(Network, LateLinksAreKeptBusyAndLoseNobody) {
  constexpr double kTask = 0.01;
  constexpr std::uint32_t kTasks = 400;
  start(30, kTask);
  Relay relay(endpoint_, {0.05, 1e9});
  const auto process = worker(relay.endpoint(), "late");
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));  // for a round trip to be measured
  give_noop_work(*dispatcher_, 20, 1, kTask);                    // and what a task costs
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  double busiest = 0;
  for (int attempt = 0; attempt < 4 && busiest < 0.75; ++attempt) {
    const std::uint64_t before = done();
    const auto begun = Clock::now();
    give_noop_work(*dispatcher_, kTasks, 1, kTask);
    ASSERT_TRUE(eventually([&] { return sink_.finished_times() == attempt + 2; }, 60));
    const double tasks = static_cast<double>(done() - before);
    busiest = std::max(busiest, tasks * kTask / since(begun));
    std::printf("%u evaluations in %.0f tasks over a round trip of 0.1 s took %.2f s: busy %.0f %%\n", kTasks,
                tasks, since(begun), 100 * tasks * kTask / since(begun));
    EXPECT_GT(tasks, 0.8 * kTasks) << "evaluations went together: nothing was to be had by credit";
    if (lossy()) break;
  }
  if (!lossy()) {
    EXPECT_GE(busiest, 0.75);
  }
  expect_nobody_lost();
}

TEST_F(Network, LargeNetworksOverASlowLinkLoseNobody) {
  start();
  Relay relay(endpoint_, {0.02, 1 << 20});
  const auto process = worker(relay.endpoint(), "thin");
  const auto begun = Clock::now();
  give_noop_work(*dispatcher_, 5, 1, 0.01, 1 << 20);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }, 60));
  std::printf("five networks of 1 MiB over a link of 1 MiB/s took %.2f s\n", since(begun));
  EXPECT_GT(since(begun), 3) << "the link was not slow";
  expect_nobody_lost();
  for (const auto& [index, times] : sink_.evaluations()) EXPECT_EQ(times, 1) << "network " << index;
}

TEST_F(Network, ASlowWorkerHoldsNothingUp) {
  start();
  const auto slow = worker(endpoint_, "slow", "sleep:3"), fast = worker(endpoint_, "fast");
  const auto begun = Clock::now();
  give_noop_work(*dispatcher_, 100, 1, 0.005);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  std::printf("beside a worker that takes 3 s a task, 100 evaluations took %.2f s\n", since(begun));
  EXPECT_LT(since(begun), 3) << "the straggler's task was not copied";
  for (const auto& [index, times] : sink_.evaluations()) EXPECT_EQ(times, 1) << "network " << index;
}

// A sink that holds up the dispatcher's thread once: what a machine without processors to spare does to it.
class AbsentSink : public CountingSink {
 public:
  void evaluated(std::uint32_t index, std::vector<proto::Measurement> measurements) override {
    if (index == 0) std::this_thread::sleep_for(std::chrono::seconds(2));
    CountingSink::evaluated(index, std::move(measurements));
  }
};

TEST(Starvation, AMasterThatDidNotListenDoesNotCallItsWorkersSilent) {
  zmq::context_t context(1);
  AbsentSink sink;
  server::DispatcherOptions options = testing::noop_options();
  options.silence_seconds = 0.6;
  auto dispatcher = std::move(*server::Dispatcher::create(context, std::move(options), sink));
  testing::RawPeer peer(context, dispatcher->endpoints()[0]);
  ASSERT_TRUE(peer.join("patient"));
  give_noop_work(*dispatcher, 1, 1, 0);
  const auto task = peer.next();
  ASSERT_TRUE(task && task->has_task());
  peer.send(peer.result_of(task->task()));
  for (int i = 0; i < 25; ++i) {  // alive all the while
    proto::Envelope alive = make_envelope(peer.stamp());
    alive.mutable_heartbeat();
    peer.send(alive);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ASSERT_EQ(sink.finished_times(), 1);
  EXPECT_EQ(sink.events("worker_lost"), 0);
}

using OtherBuild = RealRun;

TEST_F(OtherBuild, IsRefusedWithTheReasonOnBothSides) {
  Process server("evograsp-server", server_arguments(), log("server"));
  Process other("evograsp-worker-other", worker_arguments("stale", 1), log("other"));
  EXPECT_GT(other.finish(), 0) << "a refused worker ends with an error";
  const std::string reason = std::string("worker build 0.0.0, master build ") + kVersion;
  EXPECT_NE(other.log().find(reason), std::string::npos) << other.log();
  const auto right = start_worker("right");
  EXPECT_EQ(server.finish(), 0) << server.log();
  const auto refusals = events("refused");
  ASSERT_EQ(refusals.size(), 1U) << server.log();
  EXPECT_NE(refusals[0].find(reason), std::string::npos) << refusals[0];
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
}

using WrongClock = RealRun;

TEST_F(WrongClock, NothingDependsOnTheTimeOfDay) {
  const std::string preload = std::string("LD_PRELOAD=") + EVOGRASP_WRONG_CLOCK;
  Process server("evograsp-server", server_arguments(), log("server"),
                 {preload, "EVOGRASP_CLOCK_OFFSET=-150000000"});
  Process worker("evograsp-worker", worker_arguments("tomorrow", 2), log("worker"),
                 {preload, "EVOGRASP_CLOCK_OFFSET=400000000"});
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
  auto reader = server::StoreReader::open(run_dir());
  ASSERT_TRUE(reader);
  EXPECT_LT((*reader)->run()->created_at, server::unix_time() - 1e8) << "the clock was not wrong";
}

}  // namespace
}  // namespace evograsp

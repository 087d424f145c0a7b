// Workers that lie: found, named, sent away, and nothing of what they said stays.
#include <gtest/gtest.h>

#include "common/random.h"
#include "server/dispatcher.h"
#include "tests/server/raw_peer.h"
#include "tests/server/real_run.h"

namespace evograsp {
namespace {

using testing::CountingSink;
using testing::eventually;
using testing::give_noop_work;
using testing::Process;
using testing::RealRun;
using testing::TempDir;

using Liars = RealRun;

TEST_F(Liars, AreFoundAndTheChampionIsThatOfHonestWorkers) {
  Process server("evograsp-server", server_arguments({"dispatch.audit_share=1"}), log("server"));
  const auto a = start_faulty("honest-a", "sleep:0.005"), b = start_faulty("honest-b", "sleep:0.005");
  wait_for_welcome(*a);
  wait_for_welcome(*b);
  const auto liar = start_faulty("liar", "lie");
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
  const auto quarantined = events("quarantine");
  ASSERT_EQ(quarantined.size(), 1U) << server.log();
  EXPECT_NE(quarantined[0].find("worker liar is quarantined"), std::string::npos) << quarantined[0];
  EXPECT_EQ(liar->finish(), static_cast<int>(ErrorCode::kUnavailable));
  EXPECT_NE(liar->log().find("quarantined: its results for genome"), std::string::npos) << liar->log();
}

// On no-op work, whose measurements are all alike.
class LiarsAtNoop : public ::testing::Test {
 protected:
  void start(double share) {
    server::DispatcherOptions options = testing::noop_options();
    options.audit_share = share;
    options.silence_seconds = 2;
    dispatcher_ = std::move(*server::Dispatcher::create(context_, std::move(options), sink_));
    endpoint_ = dispatcher_->endpoints()[0];
  }
  // name: empty: the default, which the worker finds itself. host: empty: this one.
  std::unique_ptr<Process> worker(const std::string& name, const std::string& fault,
                                  const std::string& host = {}) {
    std::vector<std::string> arguments = {"--connect", endpoint_, "--slots", "1"};
    if (!name.empty()) arguments.insert(arguments.end(), {"--identity", name});
    std::vector<std::string> environment = {"EVOGRASP_FAULT=" + fault};
    if (!host.empty()) environment.push_back("EVOGRASP_HOST=" + host);
    auto process =
        std::make_unique<Process>("evograsp-worker-faulty", arguments,
                                  dir_.path() / (name + "-" + std::to_string(workers_.size())), environment);
    const int before = static_cast<int>(workers_.size());
    workers_.push_back(name);
    EXPECT_TRUE(eventually([&] { return sink_.events("worker_joined") > before; })) << process->log();
    EXPECT_TRUE(eventually([&] { return process->log().find("welcome") != std::string::npos; }));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // its Ready is on its way
    return process;
  }

  zmq::context_t context_{1};
  TempDir dir_;
  CountingSink sink_;
  std::vector<std::string> workers_;
  std::unique_ptr<server::Dispatcher> dispatcher_;
  std::string endpoint_;
};

TEST_F(LiarsAtNoop, TheShareThatIsAuditedIsDrawnFromAStreamOfItsOwn) {
  start(0.1);
  const auto a = worker("a", ""), b = worker("b", "");
  give_noop_work(*dispatcher_, 400, 1, 0.0003);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  std::uint64_t drawn = 0;
  for (std::uint64_t genome = 0; genome < 400; ++genome)
    drawn += Random(0, Purpose::kAudit, 0, genome).chance(0.1) ? 1 : 0;
  EXPECT_GT(drawn, 20U);
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().audits >= drawn; }));
  EXPECT_EQ(dispatcher_->view().audits, drawn) << "a network of one piece is audited once";
  EXPECT_EQ(dispatcher_->view().audit_mismatches, 0U);
  testing::expect_once(sink_, 400);
}

TEST_F(LiarsAtNoop, WhatALiarSaidBeforeItWasCaughtIsRetractedAndDoneAgain) {
  start(0.2);
  const auto a = worker("a", ""), b = worker("b", ""), liar = worker("liar", "lie");
  give_noop_work(*dispatcher_, 3000, 2, 0.0005);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  EXPECT_EQ(sink_.events("quarantine"), 1);
  testing::expect_once(sink_, 3000);
  EXPECT_GT(sink_.retractions(), 0U) << "the liar did nothing that was not audited";
  EXPECT_TRUE(sink_.all_zero_quality()) << "something that the liar said is still there";
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().quarantined == 1; }));
  const auto view = dispatcher_->view();
  const auto named = std::find_if(view.workers.begin(), view.workers.end(),
                                  [](const auto& w) { return w.identity == "liar"; });
  ASSERT_NE(named, view.workers.end());
  EXPECT_EQ(named->state, "quarantined");
}

TEST_F(LiarsAtNoop, AQuarantinedIdentityStaysOutside) {
  start(1);
  const auto a = worker("a", ""), b = worker("b", "");
  {
    const auto liar = worker("liar", "lie");
    give_noop_work(*dispatcher_, 60, 2, 0.001);
    ASSERT_TRUE(eventually([&] { return sink_.events("quarantine") == 1; }));
    EXPECT_EQ(liar->finish(), 6);
  }
  Process again("evograsp-worker", {"--connect", endpoint_, "--identity", "liar"}, dir_.path() / "again");
  EXPECT_EQ(again.finish(), 6);
  EXPECT_NE(again.log().find("quarantined"), std::string::npos) << again.log();
}

TEST_F(LiarsAtNoop, AQuarantinedLiarIsKnownByItsDefaultName) {
  start(1);
  const auto liar = worker("", "lie");
  const auto a = worker("", ""), b = worker("", "");  // of the same machine: they stay in
  give_noop_work(*dispatcher_, 60, 2, 0.001);
  ASSERT_TRUE(eventually([&] { return sink_.events("quarantine") == 1; }));
  EXPECT_EQ(liar->finish(), 6);
  Process again("evograsp-worker-faulty", {"--connect", endpoint_, "--slots", "1"}, dir_.path() / "again",
                {"EVOGRASP_FAULT=lie"});
  EXPECT_EQ(again.finish(), 6) << "it walked back in";
  EXPECT_NE(again.log().find("quarantined"), std::string::npos) << again.log();
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  EXPECT_EQ(sink_.events("worker_joined"), 3);
  EXPECT_TRUE(sink_.all_zero_quality());
}

TEST_F(LiarsAtNoop, TwoOfOneMachineDoNotConfirmEachOther) {
  start(1);
  const auto liar = worker("liar", "lie", "bad"), other = worker("other", "lie", "bad");
  const auto b = worker("b", "", "good");
  give_noop_work(*dispatcher_, 40, 2, 0.001);
  ASSERT_TRUE(eventually([&] { return sink_.events("audit_waiting") == 1; })) << "one machine decided alone";
  EXPECT_EQ(sink_.finished_times(), 0);
  EXPECT_EQ(sink_.events("quarantine"), 0);
  const auto c = worker("c", "", "fine");
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  EXPECT_EQ(sink_.events("quarantine"), 2);
  EXPECT_TRUE(sink_.all_zero_quality());
  testing::expect_once(sink_, 40);
}

TEST_F(LiarsAtNoop, TheHostOfALiarIsOnProbation) {
  start(0.2);
  const auto liar = worker("liar", "lie", "bad");
  const auto b = worker("b", "", "good"), c = worker("c", "", "fine");
  give_noop_work(*dispatcher_, 300, 1, 0.0005);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  ASSERT_EQ(sink_.events("quarantine"), 1);
  const auto under_another_name = worker("newcomer", "", "bad");
  std::this_thread::sleep_for(std::chrono::milliseconds(400));  // a view is at most 0.2 s old
  const std::uint64_t before = dispatcher_->view().audits;
  give_noop_work(*dispatcher_, 300, 1, 0.0005);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 2; }));
  std::uint64_t drawn = 0;
  for (std::uint64_t genome = 0; genome < 300; ++genome)
    drawn += Random(0, Purpose::kAudit, 0, genome).chance(0.2) ? 1 : 0;
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().audits > before + drawn + 20; }))
      << drawn << " are audited of anybody, of the newcomer all";
}

TEST_F(LiarsAtNoop, ALoneWorkerIsNotHeldUp) {
  start(1);
  const auto alone = worker("alone", "");
  give_noop_work(*dispatcher_, 100, 2, 0);
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }, 5));
  testing::expect_once(sink_, 100);
  EXPECT_EQ(sink_.events("unaudited"), 1);
  EXPECT_EQ(dispatcher_->view().audits, 0U);
}

TEST_F(LiarsAtNoop, ALiarLeftAloneForAMomentIsNotBelieved) {
  start(1);
  const auto honest = worker("honest", ""), liar = worker("liar", "lie");
  give_noop_work(*dispatcher_, 1, 2, 0);
  ASSERT_TRUE(eventually([&] { return sink_.events("worker_joined") == 2; }));
  honest->finish(SIGKILL);
  give_noop_work(*dispatcher_, 20, 2, 0);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_EQ(sink_.events("unaudited"), 0) << "the others may be back at once";
  const auto second = worker("second", ""), third = worker("third", "");
  ASSERT_TRUE(eventually([&] { return sink_.events("quarantine") == 1; }));
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() >= 1; }));
  EXPECT_TRUE(sink_.all_zero_quality()) << "a lie was believed";
}

TEST_F(LiarsAtNoop, ContradictionsOfTwoWaitForAThird) {
  start(1);
  const auto a = worker("a", ""), liar = worker("liar", "lie");
  give_noop_work(*dispatcher_, 20, 2, 0.001);
  ASSERT_TRUE(eventually([&] { return sink_.events("audit_waiting") == 1; }));
  EXPECT_EQ(sink_.finished_times(), 0) << "nobody knows yet who is right";
  EXPECT_EQ(sink_.events("quarantine"), 0);
  const auto third = worker("third", "");
  ASSERT_TRUE(eventually([&] { return sink_.finished_times() == 1; }));
  EXPECT_EQ(sink_.events("quarantine"), 1);
  EXPECT_TRUE(sink_.all_zero_quality());
  testing::expect_once(sink_, 20);
}

}  // namespace
}  // namespace evograsp

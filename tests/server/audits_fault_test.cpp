// Audits in real runs, as they are set up by default and otherwise: what they find, what an operator sees of
// it, and that the champion is the honest one.
#include <gtest/gtest.h>
#include <httplib.h>

#include <nlohmann/json.hpp>

#include "tests/server/real_run.h"

namespace evograsp {
namespace {

using nlohmann::json;
using testing::eventually;
using testing::Process;

class Audits : public testing::RealRun {
 protected:
  Audits() {
    generations_ = 15;
    http_ = testing::free_endpoint().substr(std::string("tcp://").size());
  }

  // With --stay: it answers after its run, too, until it is told to end.
  std::vector<std::string> staying(const std::vector<std::string>& settings = {}) const {
    std::vector<std::string> arguments = server_arguments(settings);
    arguments.push_back("--stay");
    return arguments;
  }
  std::string get(const std::string& path) const {
    httplib::Client client("http://" + http_);
    const auto answer = client.Get(path);
    return answer && answer->status == 200 ? answer->body : "";
  }
  json ask(const std::string& path) const { return json::parse(get(path), nullptr, false); }
  // A line of /metrics; -1: it is not there.
  double metric(const std::string& name) const {
    const std::string page = "\n" + get("/metrics");
    const auto at = page.find("\n" + name + " ");
    return at == std::string::npos ? -1 : std::strtod(page.c_str() + at + name.size() + 2, nullptr);
  }
  void wait_for_the_end(Process& server) const {
    EXPECT_TRUE(eventually([&] { return metric("evograsp_run_state{state=\"finished\"}") == 1; }, 60))
        << server.log();
  }
  void expect_champion(const std::vector<std::string>& settings = {}) const {
    EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed(settings)));
  }
};

TEST_F(Audits, AQuarantineIsSeenInEventsWorkersAndMetrics) {
  Process server("evograsp-server", staying({"dispatch.audit_share=1"}), log("server"));
  const auto a = start_faulty("honest-a", "sleep:0.005"), b = start_faulty("honest-b", "sleep:0.005");
  wait_for_welcome(*a);
  wait_for_welcome(*b);
  const auto liar = start_faulty("liar", "lie");
  EXPECT_TRUE(eventually([&] { return metric("evograsp_workers_quarantined_total") == 1; })) << server.log();
  EXPECT_TRUE(eventually([&] { return metric("evograsp_workers{state=\"quarantined\"}") == 1; }));
  EXPECT_GE(metric("evograsp_audit_mismatches_total"), 1);
  std::string state;
  const json workers = ask("/api/v1/workers");
  for (const json& worker : workers["workers"])
    if (worker["identity"] == "liar") state = worker["state"];
  EXPECT_EQ(state, "quarantined") << workers.dump(1);
  std::string text;
  const json events = ask("/api/v1/events?since=0&limit=1000");
  for (const json& event : events["events"])
    if (event["kind"] == "quarantine") text = event["text"];
  EXPECT_NE(text.find("worker liar is quarantined: its results for genome"), std::string::npos) << text;
  wait_for_the_end(server);
  server.finish(SIGTERM);
  expect_champion();
}

// A liar is not believed because the others are away, for however long.
TEST_F(Audits, WhenAllIsToBeAuditedALoneWorkerWaitsForAnother) {
  Process server("evograsp-server", server_arguments({"dispatch.audit_share=1"}), log("server"));
  const auto liar = start_faulty("liar", "lie");
  ASSERT_TRUE(eventually([&] { return !events("audit_waiting").empty(); }, 10)) << server.log();
  EXPECT_TRUE(events("unaudited").empty());
  const auto a = start_worker("honest-a", 1), b = start_worker("honest-b", 1);
  EXPECT_EQ(server.finish(), 0) << server.log();
  expect_champion();
  EXPECT_EQ(events("quarantine").size(), 1U);
}

// Of the liar's lies most are not audited, and are in the journal before one is: they must be taken out of it
// for good.
TEST_F(Audits, AKillAfterTheRetractionDoesNotBringTheLiesBack) {
  http_.clear();
  generations_ = 3;
  const std::vector<std::string> settings = {"neat.population=150", "dispatch.audit_share=0.2",
                                             "dispatch.task_seconds=0.0003"};
  Process server("evograsp-server", server_arguments(settings), log("server"));
  // So slow that the first generation is not over before the liar is here.
  const auto a = start_faulty("honest-a", "sleep:0.02"), b = start_faulty("honest-b", "sleep:0.02");
  wait_for_welcome(*a);
  wait_for_welcome(*b);
  const auto liar = start_faulty("liar", "lie-after:5");
  ASSERT_TRUE(eventually([&] { return !events("quarantine").empty() || server.ended(); }, 40))
      << server.log();
  ASSERT_FALSE(server.ended()) << server.log();
  server.finish(SIGKILL);
  EXPECT_EQ(liar->finish(), static_cast<int>(ErrorCode::kUnavailable)) << liar->log();
  const std::string text = events("quarantine").at(0);
  EXPECT_EQ(text.find("; 0 of its results"), std::string::npos) << text;
  EXPECT_NE(text.find("of generation 0"), std::string::npos) << "it lied too late for this test: " << text;
  Process again("evograsp-server", resume_arguments(), log("again"));
  const auto quick = start_worker("quick", 2);
  EXPECT_EQ(again.finish(), 0) << again.log();
  expect_champion(settings);
}

TEST_F(Audits, OneInAHundredIsAuditedByDefault) {
  generations_ = 40;
  Process server("evograsp-server", staying(), log("server"));
  const auto a = start_worker("a"), b = start_worker("b");
  wait_for_the_end(server);
  const double audits = metric("evograsp_audits_total"), evaluations = metric("evograsp_evaluations_total");
  EXPECT_GE(audits, 1);
  EXPECT_LE(audits, 0.1 * evaluations) << "of " << evaluations << " evaluations";
  EXPECT_EQ(metric("evograsp_audit_mismatches_total"), 0);
  server.finish(SIGTERM);
  expect_champion();
}

TEST_F(Audits, TheDefaultFindsWhoAlwaysLies) {
  generations_ = 40;
  Process server("evograsp-server", staying(), log("server"));
  const auto a = start_faulty("honest-a", "sleep:0.003"), b = start_faulty("honest-b", "sleep:0.003");
  const auto liar = start_faulty("liar", "lie");
  wait_for_the_end(server);
  EXPECT_EQ(metric("evograsp_workers_quarantined_total"), 1) << server.log();
  EXPECT_EQ(liar->finish(), static_cast<int>(ErrorCode::kUnavailable)) << liar->log();
  server.finish(SIGTERM);
}

TEST_F(Audits, AWorkerOfATenthOfTheSpeedIsHelpedAndChangesNothing) {
  Process server("evograsp-server", staying(), log("server"));
  const auto slow = start_faulty("slow", "slow:10");
  wait_for_welcome(*slow);
  const auto quick = start_worker("quick");
  wait_for_the_end(server);
  EXPECT_GE(metric("evograsp_tasks_total{event=\"speculated\"}"), 1) << "no straggler was copied";
  double trials = 0;
  const json workers = ask("/api/v1/workers");
  for (const json& worker : workers["workers"])
    if (worker["identity"] == "slow") trials = worker["trials"];
  EXPECT_GT(trials, 0) << "the slow one had no part in it";
  server.finish(SIGTERM);
  expect_champion();
}

}  // namespace
}  // namespace evograsp

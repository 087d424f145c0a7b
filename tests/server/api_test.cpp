// What the HTTP API answers, and what it makes a run do.
#include <chrono>
#include <thread>

#include "common/digest.h"
#include "tests/server/api_fixture.h"

namespace evograsp::server {
namespace {

using nlohmann::json;

TEST_F(ApiTest, TheRunDocumentSaysHowTheRunStands) {
  const auto [status, run] = get("/api/v1/run");
  EXPECT_EQ(status, 200);
  EXPECT_EQ(run["state"], "running");
  EXPECT_EQ(run["run_id"], "0000000000000abc");
  EXPECT_EQ(run["fitness"]["best"], 0.75);
  EXPECT_EQ(run["workers"]["active"], 1);
  EXPECT_EQ(run["workers"]["slots"], 4);
  EXPECT_TRUE(run["seconds_left"].is_null());
}

TEST_F(ApiTest, StrangersBytesInAWorkersNameStillMakeValidJson) {
  const auto [status, workers] = get("/api/v1/workers");
  EXPECT_EQ(status, 200);
  ASSERT_EQ(workers["workers"].size(), 2u);
  EXPECT_EQ(workers["workers"][1]["identity"], "n2\xef\xbf\xbd");
}

TEST_F(ApiTest, GenerationsComeInPages) {
  auto [status, page] = get("/api/v1/generations?from=1&limit=3");
  EXPECT_EQ(status, 200);
  ASSERT_EQ(page["generations"].size(), 3u);
  EXPECT_EQ(page["generations"][0]["generation"], 1);
  EXPECT_EQ(page["generations"][0]["best"], commit_of(1).record.best);
  EXPECT_EQ(page["next"], 4);
  page = get("/api/v1/generations?from=4").second;
  EXPECT_EQ(page["generations"].size(), 1u);
  EXPECT_TRUE(page["next"].is_null());
  EXPECT_EQ(get("/api/v1/generations?from=999").second["generations"].size(), 0u);
}

TEST_F(ApiTest, SpeciesAreOfTheLastGenerationUnlessAskedOtherwise) {
  EXPECT_EQ(get("/api/v1/species").second["generation"], 4);
  EXPECT_EQ(get("/api/v1/species?generation=2").second["species"][0]["age"], 2);
  EXPECT_EQ(get("/api/v1/species?generation=5").first, 404);
}

TEST_F(ApiTest, EventsAreFollowedByTheirNumber) {
  store_->note({0, 0, Severity::kWarning, "worker_lost", "n1"});
  store_->note({0, 0, Severity::kInfo, "worker_joined", "n2"});
  ASSERT_TRUE(store_->flush());
  const json first = get("/api/v1/events?limit=1").second;
  EXPECT_EQ(first["events"][0]["kind"], "worker_joined");
  const json rest = get("/api/v1/events?since=1").second;
  ASSERT_EQ(rest["events"].size(), 1u);
  EXPECT_EQ(rest["last"], 2);
  EXPECT_EQ(get("/api/v1/events?since=2").second["last"], 2);
}

TEST_F(ApiTest, TheChampionIsGivenAsBytesOrJson) {
  EXPECT_EQ(get("/api/v1/champion").first, 404);
  RunSnapshot s = *run_.snapshot();
  proto::Champion champion;
  champion.set_generation(2);
  s.champion = std::make_shared<const std::string>(deterministic_bytes(champion));
  run_.publish(s);
  EXPECT_EQ(get("/api/v1/champion").second["generation"], 2);
  const auto bytes = client().Get("/api/v1/champion?format=pb");
  EXPECT_EQ(bytes->body, *s.champion);
  EXPECT_EQ(bytes->get_header_value("X-Evograsp-Champion"), "best-so-far");
  const auto accepted = client().Get("/api/v1/champion", {{"Accept", "application/x-protobuf"}});
  EXPECT_EQ(accepted->body, *s.champion);
  EXPECT_EQ(get("/api/v1/champion?format=yaml").first, 400);
}

TEST_F(ApiTest, VerbsReachTheRun) {
  for (const char* verb : {"pause", "resume", "stop"})
    EXPECT_EQ(client().Post(std::string("/api/v1/") + verb)->status, 202) << verb;
  EXPECT_EQ(run_.log, "pause resume stop ");
  run_.ended = true;
  EXPECT_EQ(client().Post("/api/v1/pause")->status, 409);
  const auto failed = client().Post("/api/v1/checkpoint");
  EXPECT_EQ(failed->status, 500);
  EXPECT_EQ(json::parse(failed->body)["error"]["code"], "io");
  EXPECT_EQ(json::parse(failed->body)["error"]["message"], "run.db: the disk is full");
}

TEST_F(ApiTest, WorkersOfANodeAreDrained) {
  const auto ask = [&](const char* verb, const char* body) {
    return client().Post(std::string("/api/v1/workers/") + verb, body, "application/json");
  };
  const auto answer = ask("drain", R"({"node": "host1"})");
  EXPECT_EQ(answer->status, 202);
  EXPECT_EQ(json::parse(answer->body)["workers"], 3);
  EXPECT_EQ(ask("undrain", R"({"node": "host1"})")->status, 202);
  EXPECT_EQ(ask("drain", R"({"node": "host7"})")->status, 404);
  for (const char* body : {"", "{}", R"({"node": 3})", R"({"node": "host1", "x": 1})"})
    EXPECT_EQ(ask("drain", body)->status, 400) << body;
  EXPECT_EQ(run_.log, "drain undrain ");
}

TEST_F(ApiTest, TheLogLevelIsReadAndSet) {
  EXPECT_EQ(get("/api/v1/log-level").second["level"], "info");
  EXPECT_EQ(client().Put("/api/v1/log-level", R"({"level": "debug"})", "application/json")->status, 200);
  EXPECT_EQ(run_.log_level(), "debug");
  for (const char* body :
       {"", "{", "{}", "[]", R"({"level": 3})", R"({"level": "loud"})", R"({"level":"info","x":1})"})
    EXPECT_EQ(client().Put("/api/v1/log-level", body, "application/json")->status, 400) << body;
  EXPECT_EQ(run_.log_level(), "debug");
}

TEST_F(ApiTest, WhatIsNotUnderstoodIsRefusedInWords) {
  for (const char* path :
       {"/api/v1/generations?from=-1", "/api/v1/generations?from=x", "/api/v1/generations?limit=0",
        "/api/v1/generations?limit=1001", "/api/v1/generations?from=1x", "/api/v1/generations?frm=1",
        "/api/v1/generations?from=", "/api/v1/events?since=99999999999999999999", "/api/v1/run?x=1",
        "/api/v1/generations?from=4294967296"}) {
    const auto [status, body] = get(path);
    EXPECT_EQ(status, 400) << path;
    EXPECT_EQ(body["error"]["code"], "invalid") << path;
    EXPECT_FALSE(body["error"]["message"].get<std::string>().empty()) << path;
  }
}

TEST_F(ApiTest, AWrongMethodIsNamed) {
  const auto answer = client().Get("/api/v1/stop");
  EXPECT_EQ(answer->status, 405);
  EXPECT_EQ(answer->get_header_value("Allow"), "POST");
  EXPECT_EQ(client().Post("/api/v1/run")->status, 405);
  EXPECT_EQ(run_.log, "");
}

// As curl -X POST sends it: no body, and no word about one.

TEST_F(ApiTest, APostWithoutABodyIsAnsweredAtOnce) {
  const int s = raw_socket();
  const std::string request = "POST /api/v1/stop HTTP/1.1\r\nHost: localhost\r\n\r\n";
  ASSERT_EQ(::send(s, request.data(), request.size(), 0), static_cast<ssize_t>(request.size()));
  std::string answer(256, '\0');
  const auto start = std::chrono::steady_clock::now();
  const ssize_t got = ::recv(s, answer.data(), answer.size(), 0);
  ::close(s);
  answer.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  EXPECT_EQ(answer.substr(0, answer.find('\r')), "HTTP/1.1 202 Accepted");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  EXPECT_EQ(run_.log, "stop ");
}

TEST_F(ApiTest, ATakenPortIsOneClearError) {
  ApiOptions options;
  options.listen = "127.0.0.1:" + std::to_string(api_->port());
  const auto second = ApiServer::create(options, run_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kIo);
}

TEST_F(ApiTest, HealthReadinessAndMetrics) {
  EXPECT_EQ(client().Get("/healthz")->status, 200);
  EXPECT_EQ(client().Get("/readyz")->status, 200);
  const std::string metrics = client().Get("/metrics")->body;
  EXPECT_NE(metrics.find("evograsp_fitness_best 0.75\n"), std::string::npos) << metrics;
  EXPECT_NE(metrics.find("evograsp_tasks_total{event=\"requeued\"} 5\n"), std::string::npos);
  EXPECT_NE(metrics.find("evograsp_workers{state=\"active\"} 1\n"), std::string::npos);
  EXPECT_NE(metrics.find("evograsp_run_state{state=\"running\"} 1\n"), std::string::npos);
  EXPECT_NE(metrics.find("evograsp_http_answers_total{code=\"2xx\"} "), std::string::npos);
  EXPECT_NE(metrics.find("evograsp_process_resident_bytes "), std::string::npos);
  EXPECT_EQ(metrics.find("n1"), std::string::npos) << "labels are bounded";
  RunSnapshot s = *run_.snapshot();
  s.error = "disk full";
  s.state = RunState::kFailed;
  run_.publish(s);
  EXPECT_EQ(client().Get("/readyz")->status, 503);
  EXPECT_EQ(client().Get("/healthz")->status, 200);
}

TEST_F(ApiTest, DashboardFilesAreServedAsTheyAre) {
  ApiOptions options;
  options.files = {{"/", "text/html", "<html></html>", false}, {"/app.js", "text/javascript", "1", false}};
  start(options);
  EXPECT_EQ(client().Get("/")->body, "<html></html>");
  EXPECT_EQ(client().Get("/app.js")->get_header_value("Content-Type"), "text/javascript");
  EXPECT_EQ(client().Get("/appxjs")->status, 404);
}

// The deadline is the whole request's: a byte now and then does not move it.

}  // namespace
}  // namespace evograsp::server

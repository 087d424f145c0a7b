#include "server/api.h"

#include <arpa/inet.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/digest.h"
#include "server/api_http.h"
#include "server/api_json.h"
#include "tests/server/store_fixture.h"

namespace evograsp::server {
namespace {

using nlohmann::json;

// A run that remembers what it was asked.
class FakeRun final : public RunControl {
 public:
  FakeRun() {
    RunSnapshot s;
    s.name = "cube";
    s.run_id = 0xabc;
    s.seed = 7;
    s.ready = true;
    s.generation = 3;
    s.generations = 100;
    s.committed = 3;
    s.best = 0.75;
    s.mean = 0.5;
    s.species = {{1, 2, 3, 4, 0.5, 0.25}};
    s.workers = {{"n1", "host1", "0.1.0", "active", 4, 3, 10, 50, 12.5, 0.1, 0},
                 {"n2\xff", "host2", "0.1.0", "gone", 4, 3, 10, 50, 0, 99, 0}};
    s.counters.tasks_requeued = 5;
    publish(s);
  }
  void publish(RunSnapshot s) {
    const std::lock_guard lock(mutex_);
    snapshot_ = std::make_shared<const RunSnapshot>(std::move(s));
  }
  Result<std::uint32_t> drain(const std::string& node, bool drained) override {
    if (node != "host1") return fail(ErrorCode::kNotFound, "no worker is called '" + node + "'");
    log += drained ? "drain " : "undrain ";
    return 3;
  }
  std::shared_ptr<const RunSnapshot> snapshot() const override {
    const std::lock_guard lock(mutex_);
    return snapshot_;
  }
  Status pause() override { return asked("pause"); }
  Status resume() override { return asked("resume"); }
  Status stop() override { return asked("stop"); }
  Status checkpoint() override { return fail(ErrorCode::kIo, "run.db: the disk is full"); }
  std::string log_level() const override { return level_; }
  Status set_log_level(const std::string& level) override {
    level_ = level;
    return {};
  }
  std::string log;

 private:
  Status asked(const char* what) {
    if (ended) return fail(ErrorCode::kInvalid, "the run has ended");
    log += std::string(what) + " ";
    return {};
  }
  mutable std::mutex mutex_;
  std::shared_ptr<const RunSnapshot> snapshot_;
  std::string level_ = "info";

 public:
  bool ended = false;
};

int connection_to(int port) {
  const int s = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  ::inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
  EXPECT_EQ(::connect(s, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  return s;
}

class ApiTest : public testing::Test {
 protected:
  ApiTest() : store_(std::move(*Store::create(folder_.path(), new_run()))) {
    for (std::uint32_t g = 0; g < 5; ++g) EXPECT_TRUE(commit(*store_, commit_of(g)));
    start({});
  }
  void start(ApiOptions options) {
    api_.reset();
    strangers_ = std::make_shared<Strangers>();
    options.strangers = strangers_;
    options.listen = "127.0.0.1:0";
    options.run_dir = folder_.path();
    auto api = ApiServer::create(std::move(options), run_);
    ASSERT_TRUE(api) << message(api);
    api_ = std::move(*api);
  }
  httplib::Client client() const { return httplib::Client("127.0.0.1", api_->port()); }
  std::pair<int, json> get(const std::string& path) const {
    const auto answer = client().Get(path);
    if (!answer) return {0, {}};
    return {answer->status, json::parse(answer->body, nullptr, false)};
  }
  int raw_socket() const { return connection_to(api_->port()); }
  std::uint64_t refused(Offence offence) const {
    return strangers_->counts()[static_cast<std::size_t>(offence)];
  }

  RunFolder folder_;
  std::unique_ptr<Store> store_;
  FakeRun run_;
  std::shared_ptr<Strangers> strangers_;
  std::unique_ptr<ApiServer> api_;
};

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

TEST_F(ApiTest, UnknownPathsAndPathTricksAreNotFound) {
  for (const char* path :
       {"/nope", "/api/v1", "/api/v1/run/", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd",
        "/api/v1/../../etc/passwd", "//etc/passwd", "/api/v1/runx"}) {
    const auto [status, body] = get(path);
    EXPECT_EQ(status, 404) << path;
    EXPECT_EQ(body["error"]["code"], "not_found") << path;
  }
  EXPECT_EQ(refused(Offence::kPath), 4u) << "those that lead out of the folder, and no others";
}

TEST_F(ApiTest, AWrongMethodIsNamed) {
  const auto answer = client().Get("/api/v1/stop");
  EXPECT_EQ(answer->status, 405);
  EXPECT_EQ(answer->get_header_value("Allow"), "POST");
  EXPECT_EQ(client().Post("/api/v1/run")->status, 405);
  EXPECT_EQ(run_.log, "");
}

TEST_F(ApiTest, ChangesNeedTheTokenWhereThereIsOne) {
  ApiOptions options;
  options.token = "correct horse battery";
  start(options);
  EXPECT_EQ(client().Post("/api/v1/stop")->status, 401);
  EXPECT_EQ(client().Post("/api/v1/stop", {{"Authorization", "Bearer wrong"}}, "", "text/plain")->status,
            401);
  EXPECT_EQ(
      client().Post("/api/v1/stop", {{"Authorization", "correct horse battery"}}, "", "text/plain")->status,
      401);
  EXPECT_EQ(client().Put("/api/v1/log-level", R"({"level":"off"})", "application/json")->status, 401);
  EXPECT_EQ(run_.log, "");
  // The answer leaves before its line is written.
  for (int i = 0; i < 500 && refused(Offence::kToken) < 4; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(refused(Offence::kToken), 4u);
  EXPECT_NE(client().Get("/metrics")->body.find("evograsp_strangers_refused_total{offence=\"token\"} 4\n"),
            std::string::npos);
  EXPECT_EQ(strangers_->note(Offence::kToken, "127.0.0.1", "again"), std::nullopt) << "its address is known";
  EXPECT_EQ(get("/api/v1/run").first, 200) << "reading needs no token";
  const httplib::Headers right{{"Authorization", "Bearer correct horse battery"}};
  EXPECT_EQ(client().Post("/api/v1/stop", right, "", "text/plain")->status, 202);
  EXPECT_EQ(run_.log, "stop ");
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

TEST_F(ApiTest, APageInALocalBrowserCannotReachTheRun) {
  EXPECT_EQ(client().Post("/api/v1/stop", {{"Origin", "http://evil.example"}}, "", "text/plain")->status,
            403);
  EXPECT_EQ(client().Get("/api/v1/run", {{"Host", "evil.example"}})->status, 403);
  EXPECT_EQ(client().Get("/api/v1/run", {{"Host", "127.evil.example"}})->status, 403);
  EXPECT_EQ(client().Get("/api/v1/run", {{"Host", "localhost:9000"}})->status, 200) << "a forwarded port";
  EXPECT_EQ(run_.log, "");
  EXPECT_EQ(refused(Offence::kOrigin), 3u);
  EXPECT_EQ(strangers_->note(Offence::kOrigin, "127.0.0.1", "again"), std::nullopt) << "its address is known";
}

TEST_F(ApiTest, AnAddressReachableFromOutsideNeedsATokenOrAWord) {
  ApiOptions options;
  options.listen = "0.0.0.0:0";
  const auto refused = ApiServer::create(options, run_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
  options.insecure = true;
  EXPECT_TRUE(ApiServer::create(options, run_));
  for (const char* listen : {"", "8080", "127.0.0.1", "127.0.0.1:x", "127.0.0.1:70000", "::1:80", ":80"}) {
    options.listen = listen;
    EXPECT_FALSE(ApiServer::create(options, run_)) << listen;
  }
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

TEST_F(ApiTest, DawdlersDoNotKeepOthersWaiting) {
  std::vector<int> dawdlers;
  for (int i = 0; i < 64; ++i) {
    dawdlers.push_back(raw_socket());
    ASSERT_EQ(::send(dawdlers.back(), "GET /api", 8, MSG_NOSIGNAL), 8);
  }
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(client().Get("/healthz")->status, 200);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  EXPECT_LT(took.count(), 4.5) << "64 dawdlers over 16 threads, 0.3 s of patience each";
  for (const int s : dawdlers) ::close(s);
}

// The deadline is the whole request's: a byte now and then does not move it.
TEST(HttpServerTest, ADrippedRequestIsGivenUpAndItsPeerNamed) {
  std::mutex mutex;
  std::string named;
  HttpLimits limits;
  limits.request = std::chrono::milliseconds(700);
  HttpServer server(limits, [&](const std::string& peer) {
    const std::lock_guard lock(mutex);
    named = peer;
  });
  const int port = server.bind("127.0.0.1", 0);
  ASSERT_GT(port, 0);
  std::thread thread([&] { server.listen_after_bind(); });
  const int dripping = connection_to(port);
  const std::string request = "GET / HTTP/1.1\r\nX: " + std::string(1000, 'x');
  const auto start = std::chrono::steady_clock::now();
  bool ended = false;
  for (std::size_t i = 0; i < 50 && !ended; ++i) {
    static_cast<void>(::send(dripping, &request[i], 1, MSG_NOSIGNAL));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    char byte;
    const ssize_t got = ::recv(dripping, &byte, 1, MSG_DONTWAIT);
    ended = got == 0 || (got < 0 && errno != EAGAIN);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  ::close(dripping);
  server.stop();
  thread.join();
  EXPECT_TRUE(ended) << "a byte each 0.1 s keeps a thread for " << took.count() << " s";
  EXPECT_GT(took.count(), 0.5);
  EXPECT_LT(took.count(), 3.5);
  EXPECT_EQ(named, "127.0.0.1");
}

TEST_F(ApiTest, AnEndlessRequestIsCutOff) {
  const int s = raw_socket();
  // Far more than the socket buffers on both sides hold.
  const std::string flood(4096, 'x');
  ::send(s, "GET /", 5, MSG_NOSIGNAL);
  std::size_t sent = 0;
  while (sent < (64u << 20)) {
    const ssize_t n = ::send(s, flood.data(), flood.size(), MSG_NOSIGNAL);
    if (n <= 0) break;
    sent += static_cast<std::size_t>(n);
  }
  EXPECT_LT(sent, 64u << 20) << "a request line of any length was taken";
  ::close(s);
  EXPECT_EQ(refused(Offence::kRequest), 1u);
  EXPECT_EQ(client().Get("/healthz")->status, 200);
}

TEST_F(ApiTest, AHugeBodyIsRefused) {
  const auto answer = client().Put("/api/v1/log-level", std::string(1 << 20, ' '), "application/json");
  EXPECT_TRUE(!answer || answer->status == 413);
  EXPECT_EQ(client().Get("/healthz")->status, 200);
}

TEST(Token, ComesFromAFileOrTheEnvironmentAndIsNotShort) {
  RunFolder folder;
  const std::string file = (folder.path() / "token").string();
  EXPECT_FALSE(load_token(file)) << "a missing file";
  std::ofstream(file) << "0123456789abcdef\r\n";
  EXPECT_EQ(*load_token(file), "0123456789abcdef");
  std::ofstream(file) << "short\n";
  EXPECT_EQ(load_token(file).error().code, ErrorCode::kInvalid);
}

TEST(HostPort, KnowsLoopback) {
  for (const char* host : {"127.0.0.1", "127.1.2.3:80", "localhost", "localhost:8080", "[::1]", "[::1]:80"})
    EXPECT_TRUE(is_loopback_host(host)) << host;
  for (const char* host : {"", "0.0.0.0", "128.0.0.1", "[::]", "127.0.0.1.evil", "localhost.evil", "127.0.0",
                           "::1", "1270.0.0.1", "127..0.1"})
    EXPECT_FALSE(is_loopback_host(host)) << host;
}

}  // namespace
}  // namespace evograsp::server

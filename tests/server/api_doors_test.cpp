// Who gets in through the HTTP API, and who is cut off.
#include <chrono>
#include <fstream>
#include <thread>

#include "tests/server/api_fixture.h"

namespace evograsp::server {
namespace {

TEST_F(ApiTest, UnknownPathsAndPathTricksAreNotFound) {
  for (const char* path :
       {"/nope", "/api/v1", "/api/v1/run/", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd",
        "/api/v1/../../etc/passwd", "//etc/passwd", "/api/v1/runx"}) {
    const auto [status, body] = get(path);
    EXPECT_EQ(status, 404) << path;
    EXPECT_EQ(body["error"]["code"], "not_found") << path;
  }
  expect_refused(Offence::kPath, 4);  // those that lead out of the folder, and no others
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
  expect_refused(Offence::kToken, 4);
  EXPECT_NE(client().Get("/metrics")->body.find("evograsp_strangers_refused_total{offence=\"token\"} 4\n"),
            std::string::npos);
  EXPECT_EQ(strangers_->note(Offence::kToken, "127.0.0.1", "again"), std::nullopt) << "its address is known";
  EXPECT_EQ(get("/api/v1/run").first, 200) << "reading needs no token";
  const httplib::Headers right{{"Authorization", "Bearer correct horse battery"}};
  EXPECT_EQ(client().Post("/api/v1/stop", right, "", "text/plain")->status, 202);
  EXPECT_EQ(run_.log, "stop ");
}

TEST_F(ApiTest, APageInALocalBrowserCannotReachTheRun) {
  EXPECT_EQ(client().Post("/api/v1/stop", {{"Origin", "http://evil.example"}}, "", "text/plain")->status,
            403);
  EXPECT_EQ(client().Get("/api/v1/run", {{"Host", "evil.example"}})->status, 403);
  EXPECT_EQ(client().Get("/api/v1/run", {{"Host", "127.evil.example"}})->status, 403);
  EXPECT_EQ(client().Get("/api/v1/run", {{"Host", "localhost:9000"}})->status, 200) << "a forwarded port";
  EXPECT_EQ(run_.log, "");
  expect_refused(Offence::kOrigin, 3);
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
  expect_refused(Offence::kRequest, 1);
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
  for (const std::string& bad : {std::string("short\n"), std::string("\n0123456789abcdef"),
                                 std::string("0123456789abcdef\rX-Other: 1\n"), std::string(5000, 'a')}) {
    std::ofstream(file) << bad;
    EXPECT_EQ(load_token(file).error().code, ErrorCode::kInvalid) << bad;
  }
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

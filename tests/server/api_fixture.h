// An HTTP API over a run that is not there, for tests of the API.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/api.h"
#include "server/api_http.h"
#include "server/api_json.h"
#include "tests/server/store_fixture.h"

namespace evograsp::server {

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

inline int connection_to(int port) {
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
  std::pair<int, nlohmann::json> get(const std::string& path) const {
    const auto answer = client().Get(path);
    if (!answer) return {0, {}};
    return {answer->status, nlohmann::json::parse(answer->body, nullptr, false)};
  }
  int raw_socket() const { return connection_to(api_->port()); }
  std::uint64_t refused(Offence offence) const {
    return strangers_->counts()[static_cast<std::size_t>(offence)];
  }
  // An answer leaves before its refusal is counted.
  void expect_refused(Offence offence, std::uint64_t times) const {
    for (int i = 0; i < 500 && refused(offence) < times; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(refused(offence), times);
  }

  RunFolder folder_;
  std::unique_ptr<Store> store_;
  FakeRun run_;
  std::shared_ptr<Strangers> strangers_;
  std::unique_ptr<ApiServer> api_;
};

}  // namespace evograsp::server

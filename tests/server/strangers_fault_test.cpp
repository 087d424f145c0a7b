// Strangers at the door of a master that works: refused, named in few lines, bounded in memory, and the work
// goes on. Rates before and meanwhile are printed.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <fstream>

#include "common/random.h"
#include "common/zap.h"
#include "server/dispatcher.h"
#include "tests/server/raw_connection.h"
#include "tests/server/raw_peer.h"
#include "tests/server/real_run.h"

namespace evograsp {
namespace {

using testing::CountingSink;
using testing::eventually;
using testing::give_noop_work;
using testing::Process;
using testing::raw_connection;
using testing::RawPeer;
using testing::RealRun;
using testing::TempDir;
using testing::WorkerThread;
using Clock = std::chrono::steady_clock;

// Resident memory of this process, bytes.
std::size_t resident() {
  std::ifstream in("/proc/self/statm");
  std::size_t total = 0, pages = 0;
  in >> total >> pages;
  return pages * 4096;
}

class Strangers : public ::testing::Test {
 protected:
  void SetUp() override {
    gatekeeper_ = std::move(*Gatekeeper::create(context_, std::nullopt));
    server::DispatcherOptions options = testing::noop_options();
    options.socket.gatekept = true;
    options.silence_seconds = 3;
    dispatcher_ = std::move(*server::Dispatcher::create(context_, std::move(options), sink_));
    endpoint_ = dispatcher_->endpoints()[0];
    worker_ = std::make_unique<WorkerThread>(&context_, endpoint_, 2);
    keep_busy();
    ASSERT_TRUE(eventually([&] { return dispatcher_->view().tasks_done > 100; }));
  }
  // There is always work, however fast the machine.
  void keep_busy() {
    if (sink_.finished_times() < given_) return;
    give_noop_work(*dispatcher_, 50000, 1, 0.0005, 2000);
    ++given_;
  }
  double rate() {
    const auto from = dispatcher_->view().evaluations;
    const auto start = Clock::now();
    while (Clock::now() - start < std::chrono::milliseconds(700)) {
      keep_busy();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return static_cast<double>(dispatcher_->view().evaluations - from) /
           std::chrono::duration<double>(Clock::now() - start).count();
  }
  // `nuisance` is called over and over on a thread of its own; the work must go on and memory stay bounded.
  // own_losses: sessions of its own that it may lose.
  void expect_unimpressed(const char* what, const std::function<void()>& nuisance, int own_losses = 0) {
    const double before = rate();
    const std::size_t memory = resident();
    std::atomic<bool> stop{false};
    std::thread thread([&] {
      while (!stop) nuisance();
    });
    const double meanwhile = rate();
    stop = true;
    thread.join();
    const double grown = (static_cast<double>(resident()) - static_cast<double>(memory)) / 1e6;
    std::printf("%s: %.0f evaluations a second before, %.0f meanwhile; %.0f MB more memory\n", what, before,
                meanwhile, grown);
    EXPECT_GT(meanwhile, 0) << "the master does not work any more";
    EXPECT_LT(grown, 200);
    EXPECT_LE(sink_.events("worker_lost"), own_losses) << what << " cost a worker its session";
    EXPECT_LT(sink_.events("malformed"), 100) << what << " fills the log";
  }

  zmq::context_t context_{1};
  CountingSink sink_;
  std::unique_ptr<Gatekeeper> gatekeeper_;
  std::unique_ptr<server::Dispatcher> dispatcher_;
  std::unique_ptr<WorkerThread> worker_;
  std::string endpoint_;
  int given_ = 0;
};

TEST_F(Strangers, APortScannersBytes) {
  Random random(1, Purpose::kTestHarness);
  expect_unimpressed("a port scanner", [&] {
    const int fd = raw_connection(endpoint_);
    std::string bytes = "GET / HTTP/1.1\r\n\r\n" + std::string(random.below(4000), '\0');
    for (std::size_t i = 18; i < bytes.size(); ++i) bytes[i] = static_cast<char>(random.next());
    static_cast<void>(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    close(fd);
  });
}

// Pre-3.0 ZMTP begins with a length: an HTTP request is a valid beginning. Many at once, ended at once.
TEST_F(Strangers, HttpOnTheWorkerPort) {
  expect_unimpressed("HTTP requests to the worker port", [&] {
    int fds[20];
    for (int& fd : fds) {
      fd = raw_connection(endpoint_);
      const std::string bytes =
          "GET / HTTP/1.1\r\nHost: master\r\nUser-Agent: " + std::string(200, 'a') + "\r\n\r\n";
      static_cast<void>(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    }
    for (const int fd : fds) close(fd);
  });
}

TEST_F(Strangers, AMillionTinyFrames) {
  RawPeer peer(context_, endpoint_);
  int sent = 0;
  const auto thousand = [&] {
    for (int i = 0; i < 1000; ++i) peer.send_bytes("x");
    sent += 1000;
  };
  expect_unimpressed("tiny frames", thousand);
  while (sent < 1000000) thousand();
  EXPECT_GT(rate(), 0);
}

TEST_F(Strangers, OversizedFrames) {
  expect_unimpressed("frames of 8 MB where 1 MB is allowed", [&] {
    RawPeer peer(context_, endpoint_);
    peer.send_bytes(std::string(8 << 20, 'x'));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  });
}

TEST_F(Strangers, HalfOpenConnections) {
  std::vector<int> held;
  expect_unimpressed("half-open connections", [&] {
    if (held.size() < 300) held.push_back(raw_connection(endpoint_));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  for (const int fd : held) close(fd);
}

TEST_F(Strangers, HellosWithoutEnd) {
  int number = 0;
  expect_unimpressed("a hello from somebody else a millisecond", [&] {
    RawPeer peer(context_, endpoint_);
    proto::Envelope hello = peer.hello("somebody-" + std::to_string(number++));
    hello.mutable_hello()->set_build("9.9");
    peer.send(hello);
    peer.next(0.05);
  });
}

TEST_F(Strangers, RightHellosWithoutEndOverOneConnection) {
  RawPeer peer(context_, endpoint_);
  const proto::Envelope hello = peer.hello("somebody");
  const auto knock = [&] {
    for (int i = 0; i < 100; ++i) peer.send(hello);
    peer.next(0.001);
  };
  expect_unimpressed("right hellos over one connection", knock, 30);
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().refused > 100; })) << "they are refused";
  EXPECT_LT(sink_.events("worker_joined"), 30) << "each has a line, a row and a session";
  EXPECT_LT(sink_.events("refused"), 30);
}

// With keys: who is not on the list gets no word in.
class Locked : public RealRun {
 protected:
  Locked() {
    generate_keys(log("master.key"), "").value();
    const auto keys = load_keys(log("master.key"));
    const auto friendly = generate_keys(log("friend.key"), keys->public_key);
    generate_keys(log("enemy.key"), keys->public_key).value();
    std::ofstream(log("allowed")) << friendly->public_key << " friend\n";
    settings_ = {"net.curve_secret_key_file=" + log("master.key").string(),
                 "net.curve_allow_file=" + log("allowed").string()};
  }
  std::unique_ptr<Process> with_key(const std::string& name, const std::string& key) {
    std::vector<std::string> arguments = worker_arguments(name, 1);
    if (!key.empty()) arguments.insert(arguments.end(), {"--curve-key-file", log(key).string()});
    return std::make_unique<Process>("evograsp-worker", arguments, log(name));
  }
  std::vector<std::string> settings_;
};

TEST_F(Locked, OnlyTheKeyOnTheListOpens) {
  Process server("evograsp-server", server_arguments(settings_), log("server"));
  const auto enemy = with_key("enemy", "enemy.key"), nobody = with_key("nobody", "");
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_EQ(enemy->log().find("welcome"), std::string::npos);
  EXPECT_EQ(nobody->log().find("welcome"), std::string::npos);
  EXPECT_NE(server.log().find("is not on the allow-list"), std::string::npos) << server.log();
  std::size_t lines = 0;
  const std::string text = server.log();
  for (std::size_t at = 0; (at = text.find("allow-list", at)) != std::string::npos; ++at) ++lines;
  EXPECT_LE(lines, 10U) << "a stranger fills the log";
  const auto welcome = with_key("friend", "friend.key");
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
}

}  // namespace
}  // namespace evograsp

// Strangers at the doors of a master that works: refused, named in few lines, bounded in memory, and the work
// goes on. Rates before and meanwhile are printed.
#include <gtest/gtest.h>
#include <httplib.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <thread>

#include "common/random.h"
#include "common/zap.h"
#include "server/api.h"
#include "server/dispatcher.h"
#include "tests/server/cluster.h"
#include "tests/server/memory_held.h"
#include "tests/server/raw_connection.h"
#include "tests/server/raw_peer.h"

namespace evograsp {
namespace {

using testing::CountingSink;
using testing::eventually;
using testing::give_noop_work;
using testing::memory_held;
using testing::raw_connection;
using testing::RawPeer;
using testing::TempDir;
using testing::WorkerThread;
using testing::zmtp_connection;
using Clock = std::chrono::steady_clock;

constexpr double kNetworkSeconds = 0.0002;  // of a slot
constexpr double kLeastShare = 0.25;        // of the rate before

std::size_t descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

// What an HTTP server wants to know of its run: nothing goes on.
class IdleRun final : public server::RunControl {
 public:
  std::shared_ptr<const server::RunSnapshot> snapshot() const override { return snapshot_; }
  Status pause() override { return {}; }
  Status resume() override { return {}; }
  Result<std::uint32_t> drain(const std::string&, bool) override { return 0; }
  Status stop() override { return {}; }
  Status checkpoint() override { return {}; }
  std::string log_level() const override { return "info"; }
  Status set_log_level(const std::string&) override { return {}; }

 private:
  const std::shared_ptr<const server::RunSnapshot> snapshot_ = std::make_shared<server::RunSnapshot>();
};

// Counts without delay: the dispatcher's view is up to 0.2 s old.
class RatedSink : public CountingSink {
 public:
  void evaluated(std::uint32_t index, std::vector<proto::Measurement> measurements) override {
    ++evaluated_so_far;
    CountingSink::evaluated(index, std::move(measurements));
  }
  std::atomic<std::uint64_t> evaluated_so_far{0};
};

class Strangers : public ::testing::Test {
 protected:
  void SetUp() override {
    gatekeeper_ = std::move(*Gatekeeper::create(context_, std::nullopt, strangers_));
    server::DispatcherOptions options = testing::noop_options();
    options.socket.gatekept = true;
    options.silence_seconds = 3;
    options.strangers = strangers_;
    dispatcher_ = std::move(*server::Dispatcher::create(context_, std::move(options), sink_));
    endpoint_ = dispatcher_->endpoints()[0];
    worker_ = std::make_unique<WorkerThread>(&context_, endpoint_, 2);
    keep_busy();
    ASSERT_TRUE(eventually([&] { return sink_.evaluated_so_far > 1000; }));
  }
  // There is always work, however fast the machine.
  void keep_busy() {
    if (sink_.finished_times() < given_) return;
    give_noop_work(*dispatcher_, 20000, 1, kNetworkSeconds, 2000);
    ++given_;
  }
  // Evaluations a second, of the best of several windows: the machine has other things to do as well.
  double rate(int windows = 4) {
    double best = 0;
    for (int i = 0; i < windows; ++i) {
      const std::uint64_t from = sink_.evaluated_so_far;
      const auto start = Clock::now();
      while (Clock::now() - start < std::chrono::milliseconds(250)) {
        keep_busy();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      best = std::max(best, static_cast<double>(sink_.evaluated_so_far - from) /
                                std::chrono::duration<double>(Clock::now() - start).count());
    }
    return best;
  }
  // `nuisance` is called over and over on a thread of its own; the work must go on and memory stay bounded.
  // own_losses: sessions of its own that it may lose.
  void expect_unimpressed(const char* what, const std::function<void()>& nuisance, int windows = 4,
                          int own_losses = 0) {
    const double before = rate();
    const std::size_t memory = memory_held();
    std::atomic<bool> stop{false};
    std::thread thread([&] {
      while (!stop) nuisance();
    });
    const double meanwhile = rate(windows);
    const double grown = (static_cast<double>(memory_held()) - static_cast<double>(memory)) / 1e6;
    stop = true;
    thread.join();
    std::printf("%s: %.0f evaluations a second before, %.0f meanwhile; %.0f MB more memory\n", what, before,
                meanwhile, grown);
    EXPECT_GT(meanwhile, kLeastShare * before) << what << " slows the work down";
    EXPECT_LT(grown, 500) << "8 MiB of frames of one byte, 30 times as much in memory, may wait";
    EXPECT_LE(sink_.events("worker_lost"), own_losses) << what << " cost a worker its session";
    EXPECT_LT(sink_.events("malformed") + sink_.events("refused"), 10) << what << " fills the log";
  }
  std::uint64_t refused(Offence offence) const {
    return strangers_->counts()[static_cast<std::size_t>(offence)];
  }
  // Every one of them counts, and the first of an address has a line.
  void expect_counted(Offence offence, std::uint64_t number) {
    EXPECT_TRUE(eventually([&] { return refused(offence) >= number; }))
        << refused(offence) << " counted of " << number;
    EXPECT_GE(sink_.events("refused"), 1);
  }

  zmq::context_t context_{1};
  RatedSink sink_;
  const std::shared_ptr<evograsp::Strangers> strangers_ = std::make_shared<evograsp::Strangers>();
  std::unique_ptr<Gatekeeper> gatekeeper_;
  std::unique_ptr<server::Dispatcher> dispatcher_;
  std::unique_ptr<WorkerThread> worker_;
  std::string endpoint_;
  int given_ = 0;
};

TEST_F(Strangers, APortScannersBytes) {
  Random random(1, Purpose::kTestHarness);
  std::uint64_t knocks = 0;
  expect_unimpressed("a port scanner", [&] {
    const int fd = raw_connection(endpoint_);
    std::string bytes = "GET / HTTP/1.1\r\n\r\n" + std::string(random.below(4000), '\0');
    for (std::size_t i = 18; i < bytes.size(); ++i) bytes[i] = static_cast<char>(random.next());
    static_cast<void>(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    close(fd);
    ++knocks;
  });
  expect_counted(Offence::kHandshake, knocks);
}

// Pre-3.0 ZMTP begins with a length: an HTTP request is a valid beginning. Many at once, ended at once.
TEST_F(Strangers, HttpOnTheWorkerPort) {
  std::uint64_t knocks = 0;
  expect_unimpressed("HTTP requests to the worker port", [&] {
    int fds[20];
    for (int& fd : fds) {
      fd = raw_connection(endpoint_);
      const std::string bytes =
          "GET / HTTP/1.1\r\nHost: master\r\nUser-Agent: " + std::string(200, 'a') + "\r\n\r\n";
      static_cast<void>(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    }
    for (const int fd : fds) close(fd);
    knocks += 20;
  });
  expect_counted(Offence::kHandshake, knocks);
}

// Slow or fast, and none of it of any use.
TEST_F(Strangers, AtTheHttpPort) {
  IdleRun run;
  TempDir dir;
  server::ApiOptions options;
  options.listen = "127.0.0.1:0";
  options.token = "correct horse battery";
  options.run_dir = dir.path();
  options.strangers = strangers_;
  const auto api = std::move(*server::ApiServer::create(options, run));
  const std::string endpoint = "tcp://127.0.0.1:" + std::to_string(api->port());
  // One alone first: the library's sets of known methods are filled by whoever comes first, under a guard
  // that ThreadSanitizer does not see.
  EXPECT_TRUE(httplib::Client("127.0.0.1", api->port()).Get("/api/v1/run"));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // its connection is closed by then
  std::vector<int> dripping;
  for (int i = 0; i < 64; ++i) dripping.push_back(raw_connection(endpoint));
  const std::string requests[] = {"GET /../../etc/passwd HTTP/1.1\r\n\r\n",
                                  "POST /api/v1/stop HTTP/1.1\r\nContent-Length: 0\r\n\r\n",
                                  "GET /api/v1/run HTTP/1.1\r\n\r\n", std::string(40000, 'x')};
  std::size_t number = 0;
  expect_unimpressed("strangers at the HTTP port", [&] {
    for (const int fd : dripping) static_cast<void>(::send(fd, "G", 1, MSG_NOSIGNAL | MSG_DONTWAIT));
    const int fd = raw_connection(endpoint);
    const std::string& request = requests[number++ % std::size(requests)];
    static_cast<void>(::send(fd, request.data(), request.size(), MSG_NOSIGNAL));
    close(fd);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  for (const int fd : dripping) close(fd);
  for (const Offence offence : {Offence::kPath, Offence::kToken, Offence::kRequest})
    EXPECT_TRUE(eventually([&] { return refused(offence) > 0; })) << to_string(offence);
}

TEST_F(Strangers, AMillionTinyFrames) {
  constexpr std::uint64_t kFrames = 1000000;
  RawPeer peer(context_, endpoint_);
  std::uint64_t sent = 0;
  const auto thousand = [&] {
    for (int i = 0; i < 1000; ++i) sent += peer.send_waiting("x") ? 1 : 0;
    peer.ignore_answers();
  };
  expect_unimpressed("tiny frames", thousand);
  while (sent < kFrames && !HasFailure()) thousand();
  // Who sends faster than the master reads is cut off, and what was on its way is lost.
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().malformed >= kFrames; }))
      << dispatcher_->view().malformed << " arrived of " << sent;
  EXPECT_TRUE(eventually([&] { return refused(Offence::kFrame) == dispatcher_->view().malformed; }));
  EXPECT_EQ(sink_.events("malformed"), 1) << "one line, and sums later";
}

TEST_F(Strangers, OversizedFrames) {
  int sent = 0, ended = 0;
  expect_unimpressed("frames of 8 MB where 1 MB is allowed", [&] {
    RawPeer peer(context_, endpoint_);
    peer.watch();
    peer.send_bytes(std::string(8 << 20, 'x'));
    ++sent;
    ended += eventually([&] { return peer.ended(); }, 5) ? 1 : 0;
  });
  EXPECT_EQ(ended, sent) << "connections that outlived such a frame";
  EXPECT_EQ(dispatcher_->view().malformed, 0U) << "such frames reached the program";
}

// libzmq keeps the parts of a message until the last one has come.
TEST_F(Strangers, AMessageWithoutEnd) {
  const std::string part = std::string("\3\0\0\0\0\0\1\0\0", 9) + std::string(1 << 16, 'x');  // and more
  std::uint64_t ended = 0;
  expect_unimpressed("a message without end", [&] {
    const int fd = zmtp_connection(endpoint_, "DEALER");
    for (int i = 0; i < 16000; ++i)
      if (::send(fd, part.data(), part.size(), MSG_NOSIGNAL) < 0) {
        ++ended;
        break;
      }
    close(fd);
  });
  EXPECT_GT(ended, 0U) << "a gigabyte was taken";
  EXPECT_TRUE(eventually([&] { return refused(Offence::kFlood) >= ended; })) << refused(Offence::kFlood);
  EXPECT_EQ(dispatcher_->view().malformed, 0U);
}

TEST_F(Strangers, HalfOpenConnections) {
  constexpr std::size_t kHeld = 300;
  std::vector<int> held;
  const std::size_t before = descriptors();
  expect_unimpressed("half-open connections", [&] {
    if (held.size() < kHeld) held.push_back(raw_connection(endpoint_));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  while (held.size() < kHeld) held.push_back(raw_connection(endpoint_));
  const auto start = Clock::now();
  std::size_t ended = 0;
  for (const int fd : held) {
    const timeval patience{7, 0};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    char bytes[256];
    ssize_t got = 1;
    while (got > 0) got = recv(fd, bytes, sizeof bytes, 0);  // the master's greeting
    ended += got == 0 || errno == ECONNRESET ? 1 : 0;
  }
  EXPECT_EQ(ended, kHeld) << "half-open connections are held for ever";
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(7)) << "the handshake has five seconds";
  for (const int fd : held) close(fd);
  EXPECT_TRUE(eventually([&] { return descriptors() <= before; })) << descriptors() << " of " << before;
  expect_counted(Offence::kHandshake, kHeld);
}

TEST_F(Strangers, HellosWithoutEnd) {
  std::uint64_t number = 0, answered = 0;
  expect_unimpressed("a hello from somebody else a millisecond", [&] {
    RawPeer peer(context_, endpoint_);
    proto::Envelope hello = peer.hello("somebody-" + std::to_string(number++));
    hello.mutable_hello()->set_build("9.9");
    peer.send(hello);
    answered += peer.next(0.05) ? 1 : 0;
  });
  EXPECT_GT(answered, 0U);
  EXPECT_GE(refused(Offence::kHello), answered);
  EXPECT_NE(sink_.event_text("refused").find("127.0.0.1: worker somebody-"), std::string::npos)
      << sink_.event_text("refused");
}

TEST_F(Strangers, RightHellosWithoutEndOverOneConnection) {
  RawPeer peer(context_, endpoint_);
  const proto::Envelope hello = peer.hello("somebody");
  const auto knock = [&] {
    for (int i = 0; i < 100; ++i) peer.send(hello);
    peer.next(0.001);
  };
  expect_unimpressed("right hellos over one connection", knock, 4, 200);
  EXPECT_TRUE(eventually([&] { return dispatcher_->view().refused > 100; })) << "they are refused";
  // Five, and two a second, of each connection: a flood costs the connection, and the next one begins anew.
  EXPECT_LT(sink_.events("worker_joined"), 200) << "each has a line, a row and a session";
  EXPECT_LT(sink_.events("refused"), 30);
}

}  // namespace
}  // namespace evograsp

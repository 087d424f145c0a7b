// With keys: who is not on the list gets no word in, and both sides say why.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <fstream>
#include <thread>

#include "common/zap.h"
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

std::size_t times(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; ++at) ++count;
  return count;
}

class Locked : public RealRun {
 protected:
  Locked() {
    generate_keys(log("master.key"), "").value();
    const auto keys = load_keys(log("master.key"));
    const auto friendly = generate_keys(log("friend.key"), keys->public_key);
    generate_keys(log("enemy.key"), keys->public_key).value();
    const auto other = generate_keys(log("other.key"), friendly->public_key);  // takes another for the master
    std::ofstream(log("allowed")) << friendly->public_key << " friend\n"
                                  << other->public_key << " deceived\n";
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

// Each tries again and again; each is told once, on both sides.
TEST_F(Locked, OnlyTheKeyOnTheListOpens) {
  Process server("evograsp-server", server_arguments(settings_), log("server"));
  const auto enemy = with_key("enemy", "enemy.key"), nobody = with_key("nobody", ""),
             deceived = with_key("deceived", "other.key");
  EXPECT_TRUE(eventually([&] { return enemy->log().find("refused this worker's key") != std::string::npos; }))
      << enemy->log();
  EXPECT_TRUE(eventually([&] {
    return nobody->log().find("refuses peers without keys") != std::string::npos;
  })) << nobody->log();
  EXPECT_TRUE(eventually([&] { return deceived->log().find("server-key") != std::string::npos; }))
      << deceived->log();
  for (int i = 0; i < 20; ++i) {
    const int scanner = raw_connection(endpoint_);
    static_cast<void>(::send(scanner, "GET / HTTP/1.1\r\n\r\n", 18, MSG_NOSIGNAL));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    close(scanner);
  }
  for (const Process* worker : {enemy.get(), nobody.get(), deceived.get()}) {
    EXPECT_EQ(worker->log().find("welcome"), std::string::npos);
    EXPECT_LE(times(worker->log(), "[warning]"), 2U) << worker->log();
  }
  const std::string text = server.log();
  EXPECT_EQ(times(text, "127.0.0.1: key"), 1U) << text;
  EXPECT_GE(times(text, "at the worker port: "), 1U) << text;
  EXPECT_LE(times(text, "at the worker port: "), 2U) << "strangers fill the log: " << text;
  const auto welcome = with_key("friend", "friend.key");
  EXPECT_EQ(server.finish(), 0) << server.log();
  EXPECT_EQ(sha256_hex(champion()), sha256_hex(undisturbed()));
}

// Passes one connection on and keeps what its client said.
class Recorder {
 public:
  explicit Recorder(const std::string& endpoint) : target_(endpoint) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 1) != 0)
      std::abort();
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    endpoint_ = "tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this] { run(); });
  }
  const std::string& endpoint() const { return endpoint_; }
  // Ends the connection; what its client has said, piece by piece as it came.
  std::vector<std::string> stop() {
    stopping_ = true;
    thread_.join();
    close(listener_);
    return said_;
  }

 private:
  void run() {
    pollfd waiting{listener_, POLLIN, 0};
    while (poll(&waiting, 1, 10) <= 0)
      if (stopping_) return;
    const int client = accept(listener_, nullptr, nullptr), server = raw_connection(target_);
    while (!stopping_) {
      pollfd ends[2] = {{client, POLLIN, 0}, {server, POLLIN, 0}};
      poll(ends, 2, 10);
      if (ends[0].revents != 0 && !pass(client, server, true)) break;
      if (ends[1].revents != 0 && !pass(server, client, false)) break;
    }
    close(client);
    close(server);
  }
  bool pass(int from, int to, bool keep) {
    char bytes[65536];
    const ssize_t got = recv(from, bytes, sizeof bytes, 0);
    if (got <= 0) return false;
    if (keep) said_.emplace_back(bytes, static_cast<std::size_t>(got));
    return ::send(to, bytes, static_cast<std::size_t>(got), MSG_NOSIGNAL) == got;
  }

  const std::string target_;
  std::string endpoint_;
  int listener_ = -1;
  std::atomic<bool> stopping_{false};
  std::vector<std::string> said_;
  std::thread thread_;
};

// A worker joins, answers one of its tasks and goes; then somebody says all that again. What it achieves.
class Replay : public ::testing::Test {
 protected:
  void record_and_replay(const std::optional<CurveKeys>& master, const std::optional<CurveKeys>& worker) {
    std::optional<std::set<std::string>> listed;
    if (worker) listed = {worker->public_key};
    const auto gatekeeper = std::move(*Gatekeeper::create(context_, listed, strangers_));
    server::DispatcherOptions options = testing::noop_options();
    options.socket.gatekept = true;
    options.socket.curve = master;
    options.strangers = strangers_;
    const auto dispatcher = std::move(*server::Dispatcher::create(context_, options, sink_));
    Recorder recorder(dispatcher->endpoints()[0]);
    give_noop_work(*dispatcher, 4, 1, 0);
    {
      SocketOptions as_worker;
      as_worker.curve = worker;
      RawPeer peer(context_, recorder.endpoint(), as_worker);
      ASSERT_TRUE(peer.join("recorded"));
      const auto task = peer.next();
      ASSERT_TRUE(task && task->has_task());
      peer.send(peer.result_of(task->task()));
      ASSERT_TRUE(eventually([&] { return dispatcher->view().tasks_done == 1; }));
    }
    const std::vector<std::string> said = recorder.stop();
    ASSERT_GE(said.size(), 2U);
    ASSERT_TRUE(eventually([&] { return dispatcher->view().workers.empty(); }));
    say_again(dispatcher->endpoints()[0], said);
    eventually([&] { return joined() > 1 || refused() > 0; }, 3);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));  // a view is 0.2 s old at most
    tasks_done_ = dispatcher->view().tasks_done;
  }
  int joined() const { return sink_.events("worker_joined"); }
  std::uint64_t refused() const {
    return strangers_->counts()[static_cast<std::size_t>(Offence::kHandshake)];
  }

  zmq::context_t context_{1};
  CountingSink sink_;
  const std::shared_ptr<Strangers> strangers_ = std::make_shared<Strangers>();
  std::uint64_t tasks_done_ = 0;

 private:
  // At the pace of somebody who waits for answers.
  static void say_again(const std::string& endpoint, const std::vector<std::string>& said) {
    const int fd = raw_connection(endpoint);
    for (const std::string& piece : said) {
      static_cast<void>(::send(fd, piece.data(), piece.size(), MSG_NOSIGNAL));
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    close(fd);
  }
};

CurveKeys new_keys(const std::string& server_key) {
  char public_key[41] = {}, secret_key[41] = {};
  zmq_curve_keypair(public_key, secret_key);
  return {public_key, secret_key, server_key};
}

TEST_F(Replay, ASessionWithKeysCannotBeHadAgain) {
  const CurveKeys master = new_keys({});
  record_and_replay(master, new_keys(master.public_key));
  EXPECT_EQ(joined(), 1) << "a recorded handshake opened the door";
  EXPECT_EQ(tasks_done_, 1U) << "a recorded result was taken";
  EXPECT_EQ(refused(), 1U);
}

// What keys protect from, and that this test would see it.
TEST_F(Replay, ASessionInPlainTextCan) {
  record_and_replay(std::nullopt, std::nullopt);
  EXPECT_EQ(joined(), 2);
}

}  // namespace
}  // namespace evograsp

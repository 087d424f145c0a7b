// Connections that come to nothing, by their kind, seen from both sides.
#include "common/connection_monitor.h"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <chrono>
#include <optional>
#include <set>
#include <thread>

#include "common/wire.h"
#include "common/zap.h"
#include "tests/server/raw_connection.h"

namespace evograsp {
namespace {

using testing::raw_connection;
using testing::zmtp_connection;
using Why = FailedHandshake::Why;

// A worker that loses its master watches a new socket at once, often at the address of the old one.
TEST(ConnectionMonitor, CanBeMadeAnewAtOnceInTheSamePlace) {
  zmq::context_t context(1);
  std::optional<ConnectionMonitor> monitor;
  for (int i = 0; i < 200; ++i) {
    zmq::socket_t socket(context, zmq::socket_type::dealer);
    ASSERT_NO_THROW(monitor.emplace(context, socket)) << "after " << i << " monitors";
    EXPECT_TRUE(monitor->drain().closed.empty());
    monitor.reset();
  }
}

CurveKeys new_keys(const std::string& server_key = {}) {
  char public_key[41] = {}, secret_key[41] = {};
  zmq_curve_keypair(public_key, secret_key);
  return {public_key, secret_key, server_key};
}

class Door : public ::testing::Test {
 protected:
  // With keys when `keys` is given; `listed` may come in.
  void open(std::optional<CurveKeys> keys, const std::set<std::string>& listed = {}) {
    std::optional<std::set<std::string>> allowed;
    if (keys) allowed = listed;
    gatekeeper_ = std::move(*Gatekeeper::create(context_, allowed));
    SocketOptions options;
    options.gatekept = true;
    options.curve = keys;
    router_ = std::move(*make_router(context_, options));
    monitor_.emplace(context_, router_);
    endpoint_ = *bind(router_, "tcp://127.0.0.1:*");
  }
  // Until something has failed, or a second has passed.
  static std::vector<FailedHandshake> failures_of(ConnectionMonitor& monitor, double seconds = 5) {
    std::vector<FailedHandshake> all;
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (all.empty() && std::chrono::steady_clock::now() < end) {
      zmq::pollitem_t item{monitor.socket().handle(), 0, ZMQ_POLLIN, 0};
      zmq::poll(&item, 1, std::chrono::milliseconds(10));
      const auto news = monitor.drain();
      all.insert(all.end(), news.failed.begin(), news.failed.end());
    }
    return all;
  }
  void expect(const std::vector<FailedHandshake>& failures, Why why, const std::string& address) {
    ASSERT_EQ(failures.size(), 1u);
    EXPECT_EQ(to_string(failures[0].why), std::string(to_string(why)));
    EXPECT_EQ(failures[0].address, address);
  }
  // A dealer's failure and the router's, of one try.
  void expect_of_dealer(std::optional<CurveKeys> keys, std::optional<Why> at_dealer,
                        std::optional<Why> at_router) {
    SocketOptions options;
    options.curve = keys;
    zmq::socket_t dealer(context_, zmq::socket_type::dealer);
    dealer = std::move(*make_dealer(context_, "inproc://nobody", options));
    ConnectionMonitor monitor(context_, dealer);
    dealer.set(zmq::sockopt::reconnect_ivl, -1);
    dealer.connect(endpoint_);
    send(dealer, {}, to_frame("knock"));
    const auto seen = failures_of(monitor, at_dealer ? 5 : 0.3);
    ASSERT_EQ(seen.size(), at_dealer ? 1u : 0u);
    if (at_dealer) {
      EXPECT_EQ(to_string(seen[0].why), std::string(to_string(*at_dealer)));
    }
    const auto seen_here = failures_of(*monitor_, at_router ? 5 : 0.3);
    ASSERT_EQ(seen_here.size(), at_router ? 1u : 0u);
    if (at_router) {
      EXPECT_EQ(to_string(seen_here[0].why), std::string(to_string(*at_router)));
    }
  }
  void say(int descriptor, const std::string& bytes) {
    EXPECT_EQ(::send(descriptor, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  // So that the kernel is asked for its address in time.
  int caller() {
    const int descriptor = raw_connection(endpoint_);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_TRUE(monitor_->drain().failed.empty());
    return descriptor;
  }

  zmq::context_t context_{1};
  std::unique_ptr<Gatekeeper> gatekeeper_;
  zmq::socket_t router_;
  std::optional<ConnectionMonitor> monitor_;
  std::string endpoint_;
};

TEST_F(Door, TellsOfBytesThatAreNoZmtp) {
  open(std::nullopt);
  const int descriptor = caller();
  say(descriptor, "GET / HTTP/1.1\r\nHost: master\r\n\r\n");
  expect(failures_of(*monitor_), Why::kNoGreeting, "127.0.0.1");
  close(descriptor);
}

TEST_F(Door, TellsOfOldZmtp) {
  open(new_keys());
  const int descriptor = caller();
  say(descriptor, std::string("\xff\0\0\0\0\0\0\0\1\x7f\1\5", 12));  // ZMTP 2 begins so
  expect(failures_of(*monitor_), Why::kNoGreeting, "127.0.0.1");
  close(descriptor);
}

TEST_F(Door, TellsOfThoseWhoHangUp) {
  open(std::nullopt);
  close(caller());
  expect(failures_of(*monitor_), Why::kGone, "127.0.0.1");
}

TEST_F(Door, TellsNothingOfThoseWhoAreWelcome) {
  open(std::nullopt);
  for (int i = 0; i < 3; ++i) expect_of_dealer(std::nullopt, std::nullopt, std::nullopt);
  const int scanner = caller();
  say(scanner, "GET / HTTP/1.1\r\n\r\n");
  expect(failures_of(*monitor_), Why::kNoGreeting, "127.0.0.1");
  close(scanner);
}

// Which of the two sees it first hangs up: to the other it may look like that.
TEST_F(Door, PlainTextWhereKeysAreWanted) {
  open(new_keys());
  zmq::socket_t dealer = std::move(*make_dealer(context_, "inproc://nobody", {}));
  ConnectionMonitor monitor(context_, dealer);
  dealer.connect(endpoint_);
  std::set<Why> seen;
  for (int i = 0; i < 200 && !seen.contains(Why::kMechanism); ++i)
    for (const FailedHandshake& failure : failures_of(monitor)) seen.insert(failure.why);
  EXPECT_TRUE(seen.contains(Why::kMechanism));
  const auto here = failures_of(*monitor_);
  ASSERT_FALSE(here.empty());
  EXPECT_TRUE(here[0].why == Why::kMechanism || here[0].why == Why::kGone);
}

TEST_F(Door, BothSidesSayWhatIsWrongWithTheKeys) {
  const CurveKeys master = new_keys(), friendly = new_keys(master.public_key);
  open(master, {friendly.public_key});
  expect_of_dealer(friendly, std::nullopt, std::nullopt);
  // The gatekeeper tells of those who are not on the list, with their keys.
  expect_of_dealer(new_keys(master.public_key), Why::kNotListed, std::nullopt);
  EXPECT_EQ(gatekeeper_->refused(), 1u);
  expect_of_dealer(new_keys(friendly.public_key), Why::kGone, Why::kKeys);
}

// An address is right or missing, whoever comes after.
TEST_F(Door, CallersWhoAreGoneAtOnceAreCounted) {
  open(std::nullopt);
  constexpr int kCallers = 300;
  for (int i = 0; i < kCallers; ++i) {
    const int descriptor = raw_connection(endpoint_);
    say(descriptor, "GET / HTTP/1.1\r\n\r\n");
    close(descriptor);
  }
  std::size_t failed = 0;
  for (int i = 0; i < 100 && failed < kCallers; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    for (const FailedHandshake& failure : monitor_->drain().failed) {
      ++failed;
      EXPECT_TRUE(failure.address.empty() || failure.address == "127.0.0.1") << failure.address;
    }
  }
  EXPECT_EQ(failed, kCallers);
}

// Waiting for the program, or for the end of a message that has none.
TEST_F(Door, EndsFloods) {
  open(std::nullopt);
  const std::string mebibyte(1 << 20, 'x');
  const auto brought = [&](bool endless) {
    const int fd = zmtp_connection(endpoint_, "DEALER");
    const std::string head = std::string(1, endless ? '\3' : '\2') + std::string("\0\0\0\0\0\x10\0\0", 8);
    int sent = 0;
    for (; sent < 500; ++sent) {
      if (::send(fd, head.data(), head.size(), MSG_NOSIGNAL) < 0) break;
      if (::send(fd, mebibyte.data(), mebibyte.size(), MSG_NOSIGNAL) < 0) break;
      monitor_->drain();
      for (const std::string& address : monitor_->end_floods(8 << 20)) EXPECT_EQ(address, "127.0.0.1");
    }
    close(fd);
    return sent;
  };
  for (const bool endless : {false, true}) {
    const int sent = brought(endless);
    EXPECT_GE(sent, 8) << endless;
    EXPECT_LE(sent, 8 + 20) << "beside what the kernel holds of a connection";
  }
  // What is read does not count.
  const int fd = zmtp_connection(endpoint_, "DEALER");
  const std::string frame = std::string("\0\xff", 2) + std::string(255, 'x');
  std::size_t ended = 0, received = 0;
  for (int i = 0; i < 20000; ++i) {
    say(fd, frame);
    zmq::message_t peer, body;
    if (!router_.recv(peer) || !router_.recv(body)) break;
    if (body.size() != 255) --i;  // of those before
    const int descriptor = zmq_msg_get(body.handle(), ZMQ_SRCFD);
    monitor_->drain();
    monitor_->read(descriptor, wire_size(body.size(), false));
    received += body.size() == 255 ? 1 : 0;
    ended += monitor_->end_floods(1 << 20).size();
  }
  EXPECT_EQ(received, 20000u);
  EXPECT_EQ(ended, 0u);
  close(fd);
}

// libzmq 4.3.4 ends the process over the heartbeats of a broken connection whose queue is full.
TEST_F(Door, HeartbeatsAfterTheEndOfAConnectionAreNoHarm) {
  open(std::nullopt);
  constexpr int kFrames = 5000;
  const int fd = zmtp_connection(endpoint_, "DEALER");
  std::string said;
  for (int i = 0; i < kFrames; ++i) said += std::string("\0\1x\4\7\4PING\0\x64", 12);
  say(fd, said);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const linger reset{1, 0};
  setsockopt(fd, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
  close(fd);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  int received = 0;
  router_.set(zmq::sockopt::rcvtimeo, 500);
  for (zmq::message_t peer, body; router_.recv(peer) && router_.recv(body);) ++received;
  EXPECT_EQ(received, kFrames);
}

// libzmq would hold a lock that closing needs while it waits for a monitor that nobody reads.
TEST_F(Door, AFloodThatNobodyReadsDoesNotKeepTheSocketOpen) {
  open(std::nullopt);
  for (int i = 0; i < 3000; ++i) close(raw_connection(endpoint_));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  monitor_.reset();
  router_.close();
}

}  // namespace
}  // namespace evograsp

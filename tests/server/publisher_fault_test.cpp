// Strangers at the champion port: robots that ask in the right way get every new champion all the same.
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <thread>

#include "common/digest.h"
#include "server/publisher.h"
#include "tests/server/cluster.h"
#include "tests/server/memory_held.h"
#include "tests/server/raw_connection.h"

namespace evograsp::server {
namespace {

using evograsp::testing::eventually;
using evograsp::testing::memory_held;
using evograsp::testing::raw_connection;
using evograsp::testing::TempDir;
using evograsp::testing::zmtp_connection;

// A robot.
class Subscriber {
 public:
  Subscriber(const std::string& endpoint, const std::optional<CurveKeys>& keys,
             const std::string& topic = "champion", int most_waiting = 1000)
      : context_(1), socket_(context_, zmq::socket_type::sub) {
    socket_.set(zmq::sockopt::linger, 0);
    socket_.set(zmq::sockopt::rcvhwm, most_waiting);
    if (keys) {
      socket_.set(zmq::sockopt::curve_publickey, keys->public_key);
      socket_.set(zmq::sockopt::curve_secretkey, keys->secret_key);
      socket_.set(zmq::sockopt::curve_serverkey, keys->server_key);
    }
    socket_.set(zmq::sockopt::subscribe, topic);
    socket_.connect(endpoint);
  }
  // The champion's bytes; nothing after `milliseconds`.
  std::optional<std::string> next(int milliseconds) {
    socket_.set(zmq::sockopt::rcvtimeo, milliseconds);
    zmq::message_t topic, champion;
    if (!socket_.recv(topic) || !socket_.recv(champion)) return std::nullopt;
    EXPECT_EQ(topic.to_string(), "champion");
    EXPECT_FALSE(champion.more());
    return champion.to_string();
  }

 private:
  zmq::context_t context_;
  zmq::socket_t socket_;
};

class ChampionPort : public ::testing::Test {
 protected:
  void open(bool with_keys) {
    proto::NetConfig net;
    net.set_publish("tcp://127.0.0.1:*");
    net.set_max_frame_bytes(4 << 20);
    net.set_silence_seconds(1.5);
    if (with_keys) {
      const CurveKeys master = *generate_keys(dir_.path() / "master", "");
      robot_ = *generate_keys(dir_.path() / "robot", master.public_key);
      enemy_ = *generate_keys(dir_.path() / "enemy", master.public_key);
      std::ofstream(dir_.path() / "allowed") << robot_->public_key << " robot\n";
      net.set_curve_secret_key_file((dir_.path() / "master").string());
      net.set_curve_allow_file((dir_.path() / "allowed").string());
    }
    DispatcherOptions options;
    options.strangers = strangers_;
    ASSERT_TRUE(security_.open(context_, net, options));
    const Status opened = publisher_.open(context_, net, security_, strangers_);
    ASSERT_TRUE(opened) << opened.error().message;
  }
  static proto::Champion champion(std::uint32_t generation, std::size_t bytes = 0) {
    proto::Champion champion;
    champion.set_generation(generation);
    champion.set_fingerprint(std::string(bytes, 'f'));
    return champion;
  }
  // Published until it comes: a subscription needs a moment to arrive.
  bool gets(Subscriber& subscriber, std::uint32_t generation, int tries = 100) {
    for (int i = 0; i < tries; ++i) {
      publisher_.publish(champion(generation));
      publisher_.look_at_door();
      while (const auto bytes = subscriber.next(30))
        if (*bytes == deterministic_bytes(champion(generation))) return true;
    }
    return false;
  }
  std::uint64_t refused(Offence offence) const {
    return strangers_->counts()[static_cast<std::size_t>(offence)];
  }
  const std::string& endpoint() const { return publisher_.endpoint(); }

  TempDir dir_;
  zmq::context_t context_{1};
  const std::shared_ptr<Strangers> strangers_ = std::make_shared<Strangers>();
  Security security_;
  Publisher publisher_;
  std::optional<CurveKeys> robot_, enemy_;
};

TEST_F(ChampionPort, GarbageIsCountedAndARobotGetsItsChampion) {
  open(false);
  constexpr int kStrangers = 200;
  Subscriber robot(endpoint(), std::nullopt);
  ASSERT_TRUE(gets(robot, 1));
  for (int i = 0; i < kStrangers; ++i) {
    const int fd = raw_connection(endpoint());
    const std::string bytes =
        i % 2 == 0 ? "GET / HTTP/1.1\r\nHost: master\r\n\r\n" : std::string(5000, '\xff');
    static_cast<void>(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    close(fd);
  }
  EXPECT_TRUE(gets(robot, 2));
  EXPECT_TRUE(eventually([&] {
    publisher_.look_at_door();
    return refused(Offence::kHandshake) >= kStrangers;
  })) << refused(Offence::kHandshake);
}

TEST_F(ChampionPort, WithKeysOnlyTheListedGetAChampion) {
  open(true);
  Subscriber robot(endpoint(), robot_), enemy(endpoint(), enemy_), nobody(endpoint(), std::nullopt);
  ASSERT_TRUE(gets(robot, 1));
  EXPECT_TRUE(eventually([&] {
    publisher_.look_at_door();
    return refused(Offence::kKey) > 0 && refused(Offence::kHandshake) > 0;
  }));
  EXPECT_TRUE(gets(robot, 2));
  EXPECT_EQ(enemy.next(100), std::nullopt) << "a key that is not listed";
  EXPECT_EQ(nobody.next(100), std::nullopt) << "no key";
}

// Beside what the kernel holds of a connection.
TEST_F(ChampionPort, ASubscriberWhoDoesNotReadCostsLittleMemoryAndNobodyElse) {
  open(false);
  Subscriber robot(endpoint(), std::nullopt), sleeper(endpoint(), std::nullopt, "champion", 1);
  ASSERT_TRUE(gets(robot, 1));
  ASSERT_TRUE(sleeper.next(2000)) << "not connected";
  const std::size_t before = memory_held();
  for (std::uint32_t i = 0; i < 1000; ++i) {
    publisher_.publish(champion(100 + i, 200000));
    while (robot.next(i % 10 == 0 ? 5 : 0)) {
    }
  }
  const double grown = (static_cast<double>(memory_held()) - static_cast<double>(before)) / 1e6;
  EXPECT_LT(grown, 60) << "of 200 MB that were sent";
  EXPECT_TRUE(gets(robot, 2)) << "one sleeps, the other goes without";
}

// Of a topic of so many bytes. By hand: libzmq keeps topics in a tree with a branch a byte, which it takes
// down by recursion, and so runs out of stack itself.
std::string subscription(std::uint32_t bytes) {
  std::string said("\2\0\0\0\0", 5);
  for (int shift = 24; shift >= 0; shift -= 8) said.push_back(static_cast<char>((bytes + 1) >> shift));
  return said + '\1' + std::string(bytes, 't');
}

// Robots say nothing but what they want to hear of.
TEST_F(ChampionPort, HugeSubscriptionsAndTooManyEndTheirConnection) {
  open(false);
  Subscriber robot(endpoint(), std::nullopt);
  ASSERT_TRUE(gets(robot, 1));
  const auto stays = [&](std::uint32_t bytes, int times) {
    const int fd = zmtp_connection(endpoint(), "SUB");
    const std::string said = subscription(bytes);
    for (int i = 0; i < times; ++i) {
      static_cast<void>(::send(fd, said.data(), said.size(), MSG_NOSIGNAL));
      if (i % 256 == 0) publisher_.look_at_door();
    }
    char answer[4096];
    bool open = true;
    for (int i = 0; i < 200 && open; ++i) {
      publisher_.look_at_door();
      const ssize_t got = recv(fd, answer, sizeof answer, MSG_DONTWAIT);
      open = got > 0 || (got < 0 && errno == EAGAIN);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    close(fd);
    return open;
  };
  EXPECT_TRUE(stays(8, 1)) << "a modest one is welcome";
  EXPECT_FALSE(stays(1 << 20, 1)) << "its topic was taken";
  EXPECT_EQ(refused(Offence::kFlood), 0U);
  EXPECT_FALSE(stays(1000, 4000)) << "its topics were taken";
  EXPECT_GE(refused(Offence::kFlood), 1U);
  EXPECT_TRUE(gets(robot, 2));
}

}  // namespace
}  // namespace evograsp::server

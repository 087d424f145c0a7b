#include "common/wire.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/version.h"

namespace evograsp {
namespace {

// A ROUTER and a DEALER that know each other.
class Pair {
 public:
  Pair()
      : context_(1),
        router_(context_, zmq::socket_type::router),
        dealer_(context_, zmq::socket_type::dealer) {
    router_.bind("inproc://wire");
    dealer_.connect("inproc://wire");
  }
  void send_raw(std::initializer_list<std::string_view> frames) {
    std::size_t left = frames.size();
    for (const std::string_view frame : frames)
      dealer_.send(zmq::buffer(frame), --left > 0 ? zmq::send_flags::sndmore : zmq::send_flags::none);
  }
  zmq::socket_t& dealer() { return dealer_; }
  const Received& taken() {
    EXPECT_TRUE(receive(router_, true, arena_, received_)) << "nothing came";
    return received_;
  }

 private:
  zmq::context_t context_;
  zmq::socket_t router_, dealer_;
  google::protobuf::Arena arena_;
  Received received_;
};

proto::Envelope heartbeat() {
  proto::Envelope envelope = make_envelope({7, 9});
  envelope.mutable_heartbeat()->set_sequence(3);
  return envelope;
}

TEST(Wire, AttachmentsArriveAsTheyWereSent) {
  Pair pair;
  const std::string nothing, zeros(3, '\0'), large(300'000, 'x');
  ASSERT_EQ(send(pair.dealer(), {}, to_frame(heartbeat(), {nothing, zeros, large})), SendResult::kSent);
  const Received& received = pair.taken();
  ASSERT_TRUE(received.fault.empty()) << received.fault;
  EXPECT_EQ(received.envelope->run(), 7U);
  EXPECT_EQ(received.envelope->heartbeat().sequence(), 3U);
  EXPECT_EQ(received.envelope->attachment_size(), 0) << "taken out";
  ASSERT_EQ(received.attachments.size(), 3U);
  EXPECT_EQ(received.attachments[0].to_string(), nothing);
  EXPECT_EQ(received.attachments[1].to_string(), zeros);
  EXPECT_EQ(received.attachments[2].to_string(), large);
}

TEST(Wire, AFrameWithAttachmentsIsOneEnvelope) {
  proto::Envelope whole = heartbeat();
  whole.add_attachment("one");
  whole.add_attachment(std::string(200, '2'));
  proto::Envelope read;
  const std::string second(200, '2');
  const zmq::message_t frame = to_frame(heartbeat(), {"one", second});
  ASSERT_TRUE(read.ParseFromArray(frame.data(), static_cast<int>(frame.size())));
  EXPECT_EQ(read.SerializeAsString(), whole.SerializeAsString());
}

TEST(Wire, RefusesWhatIsNotOneEnvelope) {
  Pair pair;
  const auto fault = [&](std::initializer_list<std::string_view> frames) {
    pair.send_raw(frames);
    return pair.taken().fault;
  };
  const std::string good = heartbeat().SerializeAsString();
  EXPECT_EQ(fault({good}), "");
  EXPECT_EQ(fault({good, "more"}), "more than one frame in one message");
  EXPECT_EQ(fault({good, good, good}), "more than one frame in one message");
  EXPECT_EQ(fault({"\xff"}), "a frame that is not an envelope");
  EXPECT_EQ(fault({make_envelope({}).SerializeAsString()}), "an envelope without content");
  EXPECT_EQ(fault({good}), "") << "what follows a refused message is taken";
}

TEST(Wire, RefusesMoreAttachmentsThanItCounts) {
  Pair pair;
  const auto fault = [&](std::size_t count) {
    send(pair.dealer(), {}, to_frame(heartbeat(), std::vector<std::string_view>(count)));
    return pair.taken().fault;
  };
  EXPECT_EQ(fault(kMaxAttachments), "");
  EXPECT_EQ(fault(kMaxAttachments + 1), "1025 attachments, more than 1024");
}

// libzmq ends the process here when messages have several frames.
TEST(Wire, ASocketMayBeClosedWhileItsConnectionsBreak) {
  constexpr int kPeers = 8, kRounds = 5;
  const std::string network(20'000, 'n');
  const std::vector<std::string_view> networks(8, network);
  int sent = 0;
  for (int round = 0; round < kRounds; ++round) {
    zmq::context_t here(1), there(1);
    zmq::socket_t router(here, zmq::socket_type::router);
    router.set(zmq::sockopt::linger, 0);
    router.bind("tcp://127.0.0.1:*");
    std::vector<zmq::socket_t> dealers;
    std::vector<std::string> peers;
    for (int i = 0; i < kPeers; ++i) {
      zmq::socket_t& dealer = dealers.emplace_back(there, zmq::socket_type::dealer);
      dealer.set(zmq::sockopt::linger, 0);
      dealer.set(zmq::sockopt::rcvhwm, 1);
      dealer.connect(router.get(zmq::sockopt::last_endpoint));
      send(dealer, {}, heartbeat());
      zmq::message_t peer, frame;
      ASSERT_TRUE(router.recv(peer) && router.recv(frame));
      peers.push_back(peer.to_string());
    }
    for (int i = 0; i < 100; ++i)
      for (const std::string& peer : peers)
        sent += send(router, peer, to_frame(heartbeat(), networks)) == SendResult::kSent ? 1 : 0;
    std::thread leaving([&] { dealers.clear(); });
    router.close();
    leaving.join();
  }
  EXPECT_EQ(sent, kRounds * kPeers * 100);
}

}  // namespace
}  // namespace evograsp

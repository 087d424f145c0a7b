// Messages between master and worker: one frame each, an Envelope with its attachments. Everything that
// arrives is a stranger's until it has been checked here.
//
// One frame, because libzmq (4.3.4, issue 3442) ends the process when a socket is closed while a connection
// that breaks has sent a part of a multi-part message.
#pragma once

#include <google/protobuf/arena.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>
#include <zmq.hpp>

#include "common/result.h"
#include "proto/wire.pb.h"

namespace evograsp {

// More attachments than this in one message are a protocol error.
inline constexpr std::size_t kMaxAttachments = 1024;

// A larger envelope from a worker is a protocol error: what a few bytes unfold to is many. The largest result
// a scheduler asks for stays far below.
inline constexpr std::size_t kMaxEnvelopeToMaster = std::size_t{4} << 20;

// What every message of a session carries.
struct SessionStamp {
  std::uint64_t run = 0;
  std::uint64_t epoch = 0;
  bool operator==(const SessionStamp&) const = default;
};

// Serialised once, straight into the frame that will be sent.
zmq::message_t to_frame(const google::protobuf::MessageLite& message);
// Attachments are copied once, to the end of the frame.
zmq::message_t to_frame(const proto::Envelope& envelope, const std::vector<std::string_view>& attachments);
zmq::message_t to_frame(std::string_view bytes);
// A second handle on the same bytes: nothing is copied.
zmq::message_t share(zmq::message_t& frame);

// An envelope with protocol version and stamp filled in.
proto::Envelope make_envelope(const SessionStamp& stamp);

enum class SendResult { kSent, kFull, kGone };

// Sends to one peer of a ROUTER (peer: its routing id) or, with an empty peer, through a DEALER. Never
// blocks: kFull when the peer's queue is full, kGone when no such peer is connected.
SendResult send(zmq::socket_t& socket, const std::string& peer, zmq::message_t frame);
SendResult send(zmq::socket_t& socket, const std::string& peer, const proto::Envelope& envelope);

// One received message. The envelope lives in the arena given to receive().
struct Received {
  std::string peer;      // routing id; empty on a DEALER
  int fd = -1;           // connection it came by; -1 for inproc
  std::size_t size = 0;  // bytes
  proto::Envelope* envelope = nullptr;
  std::vector<zmq::message_t> attachments;  // taken out of the envelope
  std::string fault;    // not empty: the message is unacceptable, for this reason; envelope is then null
  std::string address;  // of a ROUTER's peer, without port, when its message is a hello or unacceptable
};

// Bytes that a frame of this size takes on the wire (ZMTP 3: RFC 23; with CURVE in a MESSAGE command: RFC
// 26).
std::size_t wire_size(std::size_t frame, bool encrypted);

// False when nothing is waiting.
bool receive(zmq::socket_t& socket, bool from_router, google::protobuf::Arena& arena, Received& received);

}  // namespace evograsp

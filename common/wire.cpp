#include "common/wire.h"

#include <cstring>

#include "common/version.h"

namespace evograsp {

zmq::message_t to_frame(const google::protobuf::MessageLite& message) {
  const std::size_t size = message.ByteSizeLong();
  zmq::message_t frame(size);
  message.SerializeWithCachedSizesToArray(static_cast<std::uint8_t*>(frame.data()));
  return frame;
}

zmq::message_t to_frame(std::string_view bytes) {
  return zmq::message_t(bytes.data(), bytes.size());
}

zmq::message_t share(zmq::message_t& frame) {
  zmq::message_t copy;
  copy.copy(frame);
  return copy;
}

proto::Envelope make_envelope(const SessionStamp& stamp) {
  proto::Envelope envelope;
  envelope.set_protocol(kProtocolVersion);
  envelope.set_run(stamp.run);
  envelope.set_epoch(stamp.epoch);
  return envelope;
}

SendResult send(zmq::socket_t& socket, const std::string& peer, zmq::message_t head,
                std::vector<zmq::message_t> body) {
  try {
    // Only the first frame can be refused: once it is taken, ZeroMQ takes the whole message.
    if (!peer.empty()) {
      const auto flags = zmq::send_flags::sndmore | zmq::send_flags::dontwait;
      if (!socket.send(zmq::buffer(peer), flags)) return SendResult::kFull;
    }
    const auto more = [&](std::size_t sent) {
      return sent < body.size() ? zmq::send_flags::sndmore | zmq::send_flags::dontwait
                                : zmq::send_flags::dontwait;
    };
    if (!socket.send(head, more(0))) return SendResult::kFull;
    for (std::size_t i = 0; i < body.size(); ++i)
      if (!socket.send(body[i], more(i + 1))) return SendResult::kFull;
    return SendResult::kSent;
  } catch (const zmq::error_t& error) {
    if (error.num() == EHOSTUNREACH) return SendResult::kGone;
    throw;
  }
}

SendResult send(zmq::socket_t& socket, const std::string& peer, const proto::Envelope& envelope) {
  return send(socket, peer, to_frame(envelope));
}

namespace {

// ZMQ_SRCFD is the only link that libzmq 4.3 offers between a routing id and the connection a monitor speaks
// of.
int source_fd(zmq::message_t& frame) {
  return zmq_msg_get(frame.handle(), ZMQ_SRCFD);
}

// Takes the rest of a message off the socket, keeping at most kMaxBodyFrames of it.
bool take_rest(zmq::socket_t& socket, bool more, std::vector<zmq::message_t>& body) {
  bool complete = true;
  while (more) {
    zmq::message_t frame;
    if (!socket.recv(frame)) return false;
    more = frame.more();
    if (body.size() < kMaxBodyFrames)
      body.push_back(std::move(frame));
    else
      complete = false;
  }
  return complete;
}

}  // namespace

bool receive(zmq::socket_t& socket, bool from_router, google::protobuf::Arena& arena, Received& received) {
  received.peer.clear();
  received.body.clear();
  received.fault.clear();
  received.envelope = nullptr;
  received.fd = -1;
  received.size = 0;
  zmq::message_t head;
  if (!socket.recv(head, zmq::recv_flags::dontwait)) return false;
  if (from_router) {
    received.peer.assign(static_cast<const char*>(head.data()), head.size());
    if (!head.more()) {
      received.fault = "a message without an envelope";
      return true;
    }
    if (!socket.recv(head)) return false;
    received.fd = source_fd(head);
  }
  if (!take_rest(socket, head.more(), received.body)) {
    received.fault = "too many frames in one message";
    received.body.clear();
    return true;
  }
  received.size = head.size();
  for (const zmq::message_t& frame : received.body) received.size += frame.size();
  if (from_router && head.size() > kMaxEnvelopeToMaster) {
    received.fault = "an envelope of " + std::to_string(head.size()) + " bytes, more than " +
                     std::to_string(kMaxEnvelopeToMaster);
    received.body.clear();
    return true;
  }
  auto* envelope = google::protobuf::Arena::CreateMessage<proto::Envelope>(&arena);
  if (!envelope->ParseFromArray(head.data(), static_cast<int>(head.size())))
    received.fault = "a frame that is not an envelope";
  else if (envelope->protocol() != kProtocolVersion)
    received.fault = "protocol version " + std::to_string(envelope->protocol()) + ", this is version " +
                     std::to_string(kProtocolVersion);
  else if (envelope->body_case() == proto::Envelope::BODY_NOT_SET)
    received.fault = "an envelope without content";
  else
    received.envelope = envelope;
  return true;
}

}  // namespace evograsp

#include "common/wire.h"

#include <google/protobuf/io/coded_stream.h>

#include <algorithm>

#include "common/version.h"
#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace evograsp {

namespace {

// Within one process libzmq hands a message itself from thread to thread, and does it in ways that
// ThreadSanitizer cannot see in a library not built with it: it is told that what is read was written before.
#ifdef __SANITIZE_THREAD__
void note_given(zmq::message_t& frame) {
  __tsan_release(frame.data());
}
void note_taken(zmq::message_t& frame) {
  __tsan_acquire(frame.data());
}
#else
void note_given(zmq::message_t&) {}
void note_taken(zmq::message_t&) {}
#endif

}  // namespace

zmq::message_t to_frame(const google::protobuf::MessageLite& message) {
  const std::size_t size = message.ByteSizeLong();
  zmq::message_t frame(size);
  message.SerializeWithCachedSizesToArray(static_cast<std::uint8_t*>(frame.data()));
  return frame;
}

// Fields that follow a serialised message are part of it: nothing is copied twice.
zmq::message_t to_frame(const proto::Envelope& envelope, const std::vector<std::string_view>& attachments) {
  using google::protobuf::io::CodedOutputStream;
  constexpr std::uint32_t kTag = proto::Envelope::kAttachmentFieldNumber << 3 | 2;  // length-delimited
  const std::size_t size = envelope.ByteSizeLong();
  std::size_t whole = size;
  for (const std::string_view bytes : attachments)
    whole +=
        CodedOutputStream::VarintSize32(kTag) + CodedOutputStream::VarintSize64(bytes.size()) + bytes.size();
  zmq::message_t frame(whole);
  auto* end = envelope.SerializeWithCachedSizesToArray(static_cast<std::uint8_t*>(frame.data()));
  for (const std::string_view bytes : attachments) {
    end = CodedOutputStream::WriteVarint32ToArray(kTag, end);
    end = CodedOutputStream::WriteVarint64ToArray(bytes.size(), end);
    end = std::copy(bytes.begin(), bytes.end(), end);
  }
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

std::size_t wire_size(std::size_t frame, bool encrypted) {
  if (encrypted) frame += 33;  // name, nonce, authenticator, flags
  return frame + (frame < 256 ? 2 : 9);
}

SendResult send(zmq::socket_t& socket, const std::string& peer, zmq::message_t frame) {
  note_given(frame);
  try {
    // Only the routing id can be refused: once it is taken, ZeroMQ takes the whole message.
    if (!peer.empty()) {
      const auto flags = zmq::send_flags::sndmore | zmq::send_flags::dontwait;
      if (!socket.send(zmq::buffer(peer), flags)) return SendResult::kFull;
    }
    return socket.send(frame, zmq::send_flags::dontwait) ? SendResult::kSent : SendResult::kFull;
  } catch (const zmq::error_t& error) {
    if (error.num() == EHOSTUNREACH) return SendResult::kGone;
    throw;
  }
}

SendResult send(zmq::socket_t& socket, const std::string& peer, const proto::Envelope& envelope) {
  return send(socket, peer, to_frame(envelope));
}

namespace {

constexpr std::size_t kMostNamed = 200;  // characters

// ZMQ_SRCFD is the only link that libzmq 4.3 offers between a routing id and the connection a monitor speaks
// of.
int source_fd(zmq::message_t& frame) {
  return zmq_msg_get(frame.handle(), ZMQ_SRCFD);
}

std::string source_address(zmq::message_t& frame) {
  const char* address = zmq_msg_gets(frame.handle(), "Peer-Address");
  return address != nullptr ? address : "this process";
}

// Takes what follows the first frame of a message off the socket. False: there was something.
bool nothing_follows(zmq::socket_t& socket, const zmq::message_t& first) {
  bool more = first.more();
  while (more) {
    zmq::message_t frame;
    if (!socket.recv(frame)) return false;
    more = frame.more();
  }
  return !first.more();
}

// Who greets in another version, as far as it can be understood: a name for the log, printable and short.
std::string greeting_of(const proto::Envelope& envelope) {
  if (!envelope.has_hello()) return {};
  std::string name = envelope.hello().identity().substr(0, kMostNamed);
  for (char& c : name)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return "the hello of worker " + name + " in ";
}

// Why an envelope is unacceptable; empty: it is not.
std::string fault_of(const proto::Envelope& envelope) {
  if (envelope.protocol() != kProtocolVersion)
    return greeting_of(envelope) + "protocol version " + std::to_string(envelope.protocol()) +
           ", this is version " + std::to_string(kProtocolVersion);
  if (envelope.body_case() == proto::Envelope::BODY_NOT_SET) return "an envelope without content";
  if (static_cast<std::size_t>(envelope.attachment_size()) > kMaxAttachments)
    return std::to_string(envelope.attachment_size()) + " attachments, more than " +
           std::to_string(kMaxAttachments);
  return {};
}

// What is in a frame; fills envelope and attachments, or fault.
void unpack(const zmq::message_t& frame, bool from_router, google::protobuf::Arena& arena,
            Received& received) {
  if (from_router && frame.size() > kMaxEnvelopeToMaster) {
    received.fault = "an envelope of " + std::to_string(frame.size()) + " bytes, more than " +
                     std::to_string(kMaxEnvelopeToMaster);
    return;
  }
  auto* envelope = google::protobuf::Arena::CreateMessage<proto::Envelope>(&arena);
  if (!envelope->ParseFromArray(frame.data(), static_cast<int>(frame.size())))
    received.fault = "a frame that is not an envelope";
  else
    received.fault = fault_of(*envelope);
  if (!received.fault.empty()) return;
  received.envelope = envelope;
  received.attachments.reserve(static_cast<std::size_t>(envelope->attachment_size()));
  for (const std::string& bytes : envelope->attachment()) received.attachments.push_back(to_frame(bytes));
  envelope->clear_attachment();
}

}  // namespace

bool receive(zmq::socket_t& socket, bool from_router, google::protobuf::Arena& arena, Received& received) {
  received = {};
  zmq::message_t frame;
  if (!socket.recv(frame, zmq::recv_flags::dontwait)) return false;
  if (from_router) {
    received.peer.assign(static_cast<const char*>(frame.data()), frame.size());
    if (!frame.more()) {
      received.fault = "a message without an envelope";
      received.address = source_address(frame);
      return true;
    }
    if (!socket.recv(frame)) return false;
    received.fd = source_fd(frame);
  }
  note_taken(frame);
  received.size = frame.size();
  if (nothing_follows(socket, frame))
    unpack(frame, from_router, arena, received);
  else
    received.fault = "more than one frame in one message";
  if (from_router && (received.envelope == nullptr || received.envelope->has_hello()))
    received.address = source_address(frame);
  return true;
}

}  // namespace evograsp

// The other side of a session, played by the fuzzer: messages cut out of an input, mended a little so that
// the search gets past the door.
#pragma once

#include <vector>

#include "common/version.h"
#include "common/wire.h"
#include "tests/fuzz/fuzz.h"

namespace evograsp::fuzz {

inline zmq::context_t& context() {
  static zmq::context_t context(1);
  return context;
}

inline std::string new_address() {
  static std::uint64_t number = 0;
  return "inproc://fuzz" + std::to_string(++number);
}

// One message: an envelope's bytes and up to three body frames.
struct Message {
  zmq::message_t head;
  std::vector<zmq::message_t> body;
};

// flags: 1: protocol and stamp as they should be; 2: `mend` may mend the content; the next two bits: body
// frames.
template <class Mend>
Message cut_message(Pieces& pieces, const SessionStamp& stamp, Mend mend) {
  const std::uint8_t flags = pieces.byte();
  const std::string_view bytes = pieces.bytes();
  Message message;
  proto::Envelope envelope;
  if ((flags & 3) == 0 || !envelope.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    message.head = to_frame(bytes);
  } else {
    if ((flags & 1) != 0) {
      envelope.set_protocol(kProtocolVersion);
      envelope.set_run(stamp.run);
      envelope.set_epoch(stamp.epoch);
    }
    if ((flags & 2) != 0) mend(envelope);
    message.head = to_frame(envelope);
  }
  for (int i = 0; i < (flags >> 2 & 3); ++i) message.body.push_back(to_frame(pieces.bytes()));
  return message;
}

}  // namespace evograsp::fuzz

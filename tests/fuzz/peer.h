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

// One frame: an envelope's bytes and up to three attachments.
// flags: 1: protocol and stamp as they should be; 2: `mend` may mend the content; the next two bits:
// attachments.
template <class Mend>
zmq::message_t cut_message(Pieces& pieces, const SessionStamp& stamp, Mend mend) {
  const std::uint8_t flags = pieces.byte();
  const std::string_view bytes = pieces.bytes();
  proto::Envelope envelope;
  const bool raw = (flags & 3) == 0 || !envelope.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
  std::vector<std::string_view> attachments;
  for (int i = 0; i < (flags >> 2 & 3); ++i) attachments.push_back(pieces.bytes());
  if (raw) return to_frame(bytes);
  if ((flags & 1) != 0) {
    envelope.set_protocol(kProtocolVersion);
    envelope.set_run(stamp.run);
    envelope.set_epoch(stamp.epoch);
  }
  if ((flags & 2) != 0) mend(envelope);
  return to_frame(envelope, attachments);
}

}  // namespace evograsp::fuzz

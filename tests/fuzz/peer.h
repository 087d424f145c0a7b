// The other side of a session, played by the fuzzer: messages cut out of an input, mended a little so that
// the search gets past the door.
#pragma once

#include <optional>
#include <vector>

#include "common/version.h"
#include "common/wire.h"
#include "tests/fuzz/fuzz.h"

namespace evograsp::fuzz {

inline std::optional<zmq::context_t>& kept_context() {
  static std::optional<zmq::context_t> context;
  return context;
}
inline zmq::context_t& context() {
  if (!kept_context()) kept_context().emplace(1);
  return *kept_context();
}
// Between inputs. Sockets are closed some time after they are let go: now and then that is waited for, or a
// fast run has more of them than a context can hold.
inline void settle() {
  static int inputs = 0;
  if (++inputs % 64 == 0) kept_context().reset();
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

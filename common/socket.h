// ZeroMQ sockets with the options that a master and its workers depend on, in one place.
//
// Every socket made here has LINGER 0 (shutdown never waits for a peer), a bounded frame size, ZMTP
// heartbeats, and bounded queues. A socket belongs to one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "common/result.h"

namespace evograsp {

// Keys of CURVE (Bernstein's CurveCP as used by ZeroMQ, RFC 26), Z85 text of 40 characters each.
struct CurveKeys {
  std::string public_key;
  std::string secret_key;
  std::string server_key;  // clients only: whom they expect to talk to
};

struct SocketOptions {
  std::int64_t max_frame_bytes = 64 << 20;  // a peer that sends a larger frame is disconnected
  // ZMTP ping interval; 0: none. For peers whose kernel lives and who themselves do not. Long: libzmq looks
  // through all its timers for each ping, of thousands of connections.
  double heartbeat_seconds = 10;
  // The transport is given up after this long without an answer to a ping, to the kernel's own (TCP
  // keep-alive) or to data. Masters and workers notice silence sooner, by heartbeats of their own; this one
  // is for what they do not watch. Not short: an I/O thread that gets no processor looks at its timers before
  // it looks at what has arrived.
  double silence_seconds = 6;
  int high_water = 1000;  // messages queued a peer, each way
  // ROUTERs: of one peer's messages, no more bytes than this wait here to be read; what else it sends stays
  // on its side. Holds for messages of one frame, as workers send them: libzmq counts messages, not frames.
  std::int64_t queue_bytes = 128 << 20;
  std::optional<CurveKeys> curve;  // absent: plain text
  // Servers: each handshake is put to the context's Gatekeeper (common/zap.h), which must be there. Beside
  // who comes in, this decides in which language: libzmq 4.3 then refuses ZMTP 1 and 2, whose first message,
  // from any port scanner, can trip an assertion and end the process (zmtp_engine.cpp,
  // process_routing_id_msg).
  bool gatekept = false;
};

// True for inproc, ipc and addresses of the loopback interface ("tcp://127.0.0.1:5555", "tcp://[::1]:5555",
// "tcp://localhost:5555").
bool is_loopback(const std::string& endpoint);

// An error unless the endpoint is loopback, encrypted, or insecurity has been asked for in so many words.
Status check_exposure(const std::string& endpoint, bool encrypted, bool insecure);

// A ROUTER, not bound yet. Sends to unknown peers fail (EHOSTUNREACH) instead of vanishing. With CURVE keys
// every handshake is put to the context's ZAP handler (common/zap.h).
Result<zmq::socket_t> make_router(zmq::context_t& context, const SocketOptions& options);
// A PUB, not bound yet. Slow subscribers miss messages; they never hold up the sender.
Result<zmq::socket_t> make_publisher(zmq::context_t& context, const SocketOptions& options);
// Binds one more endpoint; gives what was really bound: "tcp://127.0.0.1:*" becomes the port that was free.
Result<std::string> bind(zmq::socket_t& socket, const std::string& endpoint);

// A DEALER connected to one endpoint; reconnects by itself at random intervals between 50 and 500 ms.
Result<zmq::socket_t> make_dealer(zmq::context_t& context, const std::string& endpoint,
                                  const SocketOptions& options);

// Of the other end of a TCP connection, without its port; empty when there is none.
std::string peer_address(int descriptor);

// Wakes a thread that waits in zmq_poll, from any thread or signal handler.
class Wakeup {
 public:
  Wakeup();
  ~Wakeup();
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  int fd() const { return fd_; }
  void notify() noexcept;  // async-signal-safe
  void clear() noexcept;

 private:
  int fd_;
};

}  // namespace evograsp

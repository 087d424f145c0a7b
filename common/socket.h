// ZeroMQ sockets with the options that a master and its workers depend on, in one place.
//
// Every socket made here has LINGER 0 (shutdown never waits for a peer), a bounded frame size and bounded
// queues. A socket belongs to one thread.
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
  // The transport is given up after this long without an answer to the kernel's probes (TCP keep-alive) or to
  // data. Masters and workers notice silence sooner, by heartbeats of their own; this one is for what they do
  // not watch. Not short: an I/O thread that gets no processor looks at its timers before it looks at what
  // has arrived.
  //
  // There are no ZMTP heartbeats, for the same reason as high_water's.
  double silence_seconds = 6;
  // Messages queued for each peer. What servers receive is not bounded here, but by whoever reads it
  // (ConnectionMonitor::end_floods): libzmq 4.3.4 ends the process when the connection of a peer whose queue
  // is full breaks and a ZMTP heartbeat, of either side, comes next (stream_engine_base.cpp, "!_io_error").
  int high_water = 1000;
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

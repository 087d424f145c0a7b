// What happens to the connections of a socket: which ended, and which came to nothing, and why.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>
#include <zmq.hpp>

namespace evograsp {

// A connection that ended before its handshake was over.
struct FailedHandshake {
  enum class Why {
    kNoGreeting,  // bound sockets: bytes that are no greeting of ZMTP 3 (HTTP, scanners, ZMTP 1 and 2)
    kGone,        // hung up, or said nothing for the five seconds it had; how a server with CURVE refuses
                  // clients that take it for another
    kMechanism,   // one side wants keys, the other has none
    kKeys,        // CURVE boxes that do not open: made for another public key
    kNotListed,   // connecting sockets: the server refuses the key
    kProtocol,    // anything else that breaks ZMTP
  };
  Why why = Why::kProtocol;
  std::string
      address;  // of the peer, without port; bound sockets only. Empty: it was gone before it could be asked
};
// "speaks no ZMTP 3 ...": a predicate whose subject is the peer of a bound socket.
const char* to_string(FailedHandshake::Why why);

// One socket, one monitor; same thread as the socket. It knows nothing of connections made before it. Drain
// it often: what happens waits in memory, without a bound, since libzmq's I/O thread would wait otherwise,
// under a lock that closing the socket needs.
//
// Ended connections are told by their descriptor, long before any heartbeat would miss them. libzmq 4.3 says
// less of those that fail: no descriptor (that of the DISCONNECTED event which follows at once is it), no
// address (asked of the kernel when the connection is announced, and believed only when the connection had
// not ended by then), and nothing at all of peers whose first bytes are no ZMTP 3: those are the ones that
// end while fewer handshakes have succeeded than would account for them.
//
// It also ends the connections of peers that send faster than they are read, or a message that never ends:
// libzmq's own bounds (messages, not frames; and see SocketOptions) do not.
class ConnectionMonitor {
 public:
  // Throws zmq::error_t.
  ConnectionMonitor(zmq::context_t& context, zmq::socket_t& watched);
  ~ConnectionMonitor();
  ConnectionMonitor(const ConnectionMonitor&) = delete;
  ConnectionMonitor& operator=(const ConnectionMonitor&) = delete;

  zmq::socket_t& socket() { return events_; }  // readable when something has happened
  struct News {
    std::vector<int> closed;              // descriptors, whether the handshake had been over or not
    std::vector<FailedHandshake> failed;  // of these
  };
  News drain();  // since the last call
  // So many bytes that came by this connection have been read by the program.
  void read(int descriptor, std::size_t bytes);
  // Ends the connections that have brought more than `most` bytes which the program has not read; whose they
  // were. Costs about a microsecond a connection.
  std::vector<std::string> end_floods(std::uint64_t most);
  std::size_t connections() const { return read_.size(); }
  // A message came by this connection: its handshake is over. Not before drain(), which may tell of its
  // beginning.
  void spoke(int descriptor);

 private:
  struct Caller {  // accepted, and not known to be through with its handshake
    std::string address;
    bool asked = false, sure = false;  // sure: the connection was alive when the kernel was asked
  };
  void handle(std::uint16_t kind, std::int32_t value, News& news);
  void succeeded();
  void ended(int descriptor, News& news);
  void ask_addresses();
  void believe_addresses();
  bool read_waiting(News& news);

  zmq::socket_t& watched_;
  zmq::socket_t events_;
  bool bound_ = false;
  std::unordered_map<int, std::uint64_t> read_;  // bytes, of each connection that is open
  std::unordered_map<int, Caller> callers_;      // by descriptor
  std::vector<int> unasked_, unsure_;            // of these
  std::size_t through_ = 0;                      // of these, which ones is not known
  bool has_failed_ = false;                      // the connection whose end comes next
  FailedHandshake::Why why_{};
};

}  // namespace evograsp

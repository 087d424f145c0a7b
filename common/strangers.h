// What strangers do at the doors of a process (worker port, champion port, HTTP port), told once.
//
// The first offence of each kind of each peer address makes a line for the log, with its reason. What follows
// is counted and summed up in a later line ("and 312 more"): after a minute, then after two, four, up to an
// hour, until the address has been quiet as long. Bounded whatever comes: the addresses kept (those heard of
// longest ago are forgotten first) and the lines of all addresses together; what exceeds these bounds is
// counted and told as one sum. Thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/log.h"
#include "common/mutex.h"

namespace evograsp {

enum class Offence {
  kHandshake,  // no ZMTP 3, or a connection that is given up before its handshake is over
  kKey,        // a key that is not on the list
  kFrame,      // a message that a peer must not send
  kFlood,      // sends faster than it is read, or a message without end
  kHello,      // another build, experiment or identity
  kToken,      // HTTP: no bearer token, or a wrong one
  kOrigin,     // HTTP: a foreign page in a local browser
  kPath,       // HTTP: a path that tries to leave the folder
  kRequest,    // HTTP: no request that can be understood, too large, or never finished
};
inline constexpr std::size_t kOffences = 9;
const char* to_string(Offence offence);  // "handshake": a label of /metrics

class Strangers {
 public:
  struct Limits {
    std::size_t addresses = 4096;  // kept, of every kind
    int burst = 50;                // lines at once, of all addresses
    double seconds = 1;            // until there may be one more
    double again = 60;             // s between the lines of one address, at first
    double longest = 3600;         // s, at last
  };
  using Clock = std::function<double()>;  // s, monotonic
  Strangers();
  explicit Strangers(Limits limits, Clock clock);

  // Counts one more. address: without port; empty: unknown. what: printable, without its address. The line to
  // log, if there is one.
  std::optional<std::string> note(Offence offence, const std::string& address, const std::string& what);
  // Sums that are due. To be called about once a second.
  std::vector<std::string> sums();
  // note() and log.
  void tell(Offence offence, const std::string& address, const std::string& what);

  using Counts = std::array<std::uint64_t, kOffences>;  // by Offence
  Counts counts() const;
  std::size_t addresses() const;  // kept now

 private:
  struct Entry {
    std::string key, address, what;
    std::uint64_t untold = 0;
    double pause = 0, due = 0;  // s; s of the clock
  };
  using Entries = std::list<Entry>;

  Entry& entry_of(Offence offence, const std::string& address, double now) REQUIRES(mutex_);
  std::optional<std::string> line_of(Entry& entry, double now) REQUIRES(mutex_);

  const Limits limits_;
  const Clock clock_;
  mutable Mutex mutex_;
  Entries entries_ GUARDED_BY(mutex_);  // heard of last first
  std::unordered_map<std::string, Entries::iterator> by_key_ GUARDED_BY(mutex_);
  LogLimiter lines_ GUARDED_BY(mutex_);
  std::uint64_t forgotten_ GUARDED_BY(mutex_) = 0;  // offences, untold, of addresses that are kept no more
  double next_forgotten_ GUARDED_BY(mutex_) = 0;
  Counts counts_ GUARDED_BY(mutex_){};
};

}  // namespace evograsp

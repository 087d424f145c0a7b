// The master's one door to its workers: a ROUTER socket on a thread of its own.
//
// Thread-safe: every method may be called from any thread and returns at once.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/socket.h"
#include "common/strangers.h"
#include "common/wire.h"
#include "server/work.h"

namespace evograsp::server {

// A bundle as it is served.
struct ServedAsset {
  std::string id;
  std::string packed;
};

struct DispatcherOptions {
  std::vector<std::string> endpoints;  // e.g. tcp://127.0.0.1:5555, inproc://evograsp
  SocketOptions socket;
  SchedulerOptions scheduler;
  SessionStamp stamp;
  double heartbeat_seconds = 0.5;
  double silence_seconds = 1.5;
  double audit_share = 0;        // of the networks: done again by another worker and compared bit for bit
  bool audits_required = false;  // a worker that is alone waits for another; else audits are left out
  proto::Experiment experiment;  // without objects: workers make no simulator and serve no-op tasks alone
  std::vector<ServedAsset> assets;
  std::shared_ptr<Strangers> strangers;  // told of those that are refused; absent: the dispatcher has its own
};

class Dispatcher {
 public:
  // Binds and starts serving. `sink` outlives the dispatcher. `context`: of the sockets; shared with workers
  // of the same process.
  static Result<std::unique_ptr<Dispatcher>> create(zmq::context_t& context, DispatcherOptions options,
                                                    WorkSink& sink);
  virtual ~Dispatcher() = default;  // tells the workers goodbye

  // Begins new work; what was left of the old is dropped.
  virtual void begin(Work work) = 0;
  // Networks first, first + 1, ... of the work begun last: given out as soon as they are here.
  virtual void add(std::uint32_t first, std::vector<NetworkFrame> networks) = 0;
  virtual void abandon() = 0;
  virtual void set_paused(bool paused) = 0;
  // No more work for the workers of this host, or of this identity; or work again.
  virtual void set_drained(std::string node, bool drained) = 0;
  // Tells every worker that there is no more work to come.
  virtual void dismiss(std::string reason) = 0;

  // At most 0.2 s old.
  virtual DispatchView view() const = 0;
  // What was bound, free ports resolved; in the order of the options.
  virtual std::vector<std::string> endpoints() const = 0;
};

}  // namespace evograsp::server

// A worker: one connection to a master, N simulator slots.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/result.h"
#include "common/socket.h"

namespace evograsp::worker {

struct WorkerOptions {
  std::string connect = "tcp://127.0.0.1:5555";  // or inproc://evograsp with a shared context
  // A file that says where the master is (common/rendezvous.h), instead of `connect`: read anew for each
  // connection, and waited for while it is not there.
  std::string rendezvous;
  double wait_seconds = 0;  // give up without a master for this long; 0: never
  int slots = 0;            // 0: one a core
  // Unique among the workers of a master, and the same after a restart. Default: worker/seat.h.
  std::string identity;
  // The machine: an audit is done on another. Default: what it calls itself; in a container, better its
  // node's.
  std::string host;
  bool once = false;  // return when the master says that its run is over, instead of waiting for the next
  std::string alive_file;          // written every second with what the worker does; empty: none
  double drain_seconds = 10;       // drain() gives running tasks this long
  std::optional<CurveKeys> curve;  // needed for a master that listens beyond its machine
  zmq::context_t* context = nullptr;
};

class Worker {
 public:
  static Result<std::unique_ptr<Worker>> create(WorkerOptions options);
  virtual ~Worker() = default;
  // Serves until drained, refused for good, or stopped. Reconnects with backoff and jitter when the master
  // goes away. Blocks. kUnavailable: refused for good, no master for wait_seconds, or a slot did not finish
  // in time when drained; kInvalid: the master's experiment cannot be simulated here, or no rendezvous is in
  // the file.
  virtual Status run() = 0;
  virtual void drain() = 0;  // finish what has started, hand back the rest, say goodbye; from any thread
  virtual void stop() = 0;   // at once
};

}  // namespace evograsp::worker

// The master: evolution loop, dispatcher, store and HTTP API of one run, in one process.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "assets/assets.h"
#include "common/result.h"
#include "proto/config.pb.h"
#include "proto/genome.pb.h"

namespace zmq {
class context_t;
}

namespace evograsp::server {

struct ServerOptions {
  proto::Config config;                   // every default written out; taken from run.db when resuming
  assets::ResolvedExperiment experiment;  // unused when resuming: run.db holds the bundles
  std::filesystem::path run_dir;          // holds run.db; made when missing
  bool resume = false;
  // Fields set here replace those of config.net, and of the stored config when resuming.
  proto::NetConfig net;
  // When set, the dispatcher also binds inproc://evograsp in this context: `evograsp train` puts a Worker
  // there.
  zmq::context_t* context = nullptr;
};

// What a generation amounted to, as committed.
struct GenerationReport {
  std::uint32_t generation = 0;
  double best = 0, mean = 0;
  std::uint32_t species = 0;
  std::uint64_t trials = 0;  // so far
  double seconds = 0;        // wall time of this run so far, resumed parts included
};

enum class RunState { kRunning, kPaused, kFinished, kStopped, kFailed };

class RunControl;

class Server {
 public:
  // Opens the store, binds every socket; nothing runs yet.
  static Result<std::unique_ptr<Server>> create(ServerOptions options);
  virtual ~Server() = default;

  // Called after each commit, on the run loop's thread; must not block.
  virtual void on_generation(std::function<void(const GenerationReport&)> callback) = 0;
  // Runs to the end, or until stop(). Blocks. The champion has been validated and committed when it returns
  // kFinished.
  virtual Result<RunState> run() = 0;
  // Asks the run to commit what it has and return: async-signal-unsafe, callable from any thread.
  virtual void stop() = 0;
  virtual Result<proto::Champion> champion() const = 0;

  // What was bound, free ports resolved; the inproc endpoint included.
  virtual std::vector<std::string> endpoints() const = 0;
  virtual int http_port() const = 0;            // 0: no HTTP
  virtual std::string http_listen() const = 0;  // net.http as it is in force
  // Snapshots, pause, resume, checkpoint: server/run_control.h.
  virtual RunControl& control() = 0;
};

}  // namespace evograsp::server

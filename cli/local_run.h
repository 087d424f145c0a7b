// A run on this machine: a server and a worker in one process, joined by an inproc socket.
#pragma once

#include <functional>
#include <memory>
#include <zmq.hpp>

#include "common/config.h"
#include "server/server.h"
#include "worker/worker.h"

namespace evograsp::cli {

class LocalRun {
 public:
  // slots: simulators at work at once; 0: one a core. Nothing runs yet.
  static Result<std::unique_ptr<LocalRun>> create(server::ServerOptions options, int slots);

  // To the end, or until stop(). When it returns, run.db can be opened by others once this object is gone.
  Result<server::RunState> run(std::function<void(const server::GenerationReport&)> on_generation);
  void stop();  // any thread: commits what there is and ends run()

 private:
  LocalRun() = default;
  zmq::context_t context_;
  std::unique_ptr<server::Server> server_;
  std::unique_ptr<worker::Worker> worker_;
};

// Nobody else joins a run on this machine unless asked: then no port is taken and two runs go side by side.
void close_doors(LoadedConfig& loaded);

// For a new run in `folder`: the config's assets resolved (their warnings are told), doors closed. Refuses a
// folder that holds a run.
Result<server::ServerOptions> new_run(LoadedConfig loaded, const std::filesystem::path& folder);
// For the rest of the run in `folder`.
Result<server::ServerOptions> resumed_run(const std::filesystem::path& folder);

}  // namespace evograsp::cli

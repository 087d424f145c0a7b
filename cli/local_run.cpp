#include "cli/local_run.h"

#include <functional>
#include <new>
#include <system_error>
#include <thread>

#include "cli/report.h"
#include "cli/run_folder.h"
#include "server/store.h"

namespace evograsp::cli {

namespace fs = std::filesystem;

namespace {

// A worker on a thread of its own; stops it at the end.
class Beside {
 public:
  Beside(worker::Worker& worker, const std::function<void()>& work) : worker_(worker), thread_(work) {}
  ~Beside() {
    worker_.stop();
    thread_.join();
  }
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;

 private:
  worker::Worker& worker_;
  std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<LocalRun>> LocalRun::create(server::ServerOptions options, int slots) {
  std::unique_ptr<LocalRun> run(new LocalRun);
  options.context = &run->context_;
  auto server = server::Server::create(std::move(options));
  if (!server) return tl::unexpected(server.error());
  run->server_ = std::move(*server);
  worker::WorkerOptions how;
  how.connect = "inproc://evograsp";
  how.slots = slots;
  how.context = &run->context_;
  auto worker = worker::Worker::create(how);
  if (!worker) return tl::unexpected(worker.error());
  run->worker_ = std::move(*worker);
  return run;
}

Result<server::RunState> LocalRun::run(std::function<void(const server::GenerationReport&)> on_generation) {
  server_->on_generation(std::move(on_generation));
  Status worked;
  const auto work = [this, &worked] {
    worked = worker_->run();
    if (!worked) server_->stop();
  };
  const auto serve = [&] {  // whatever the server throws, its worker ends first
    const Beside beside(*worker_, work);
    return server_->run();
  };
  try {
    auto state = serve();
    if (!worked) return tl::unexpected(worked.error());
    return state;
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kIo, "not enough memory for this run on this machine");
  } catch (const std::system_error& error) {
    return fail(ErrorCode::kUnavailable, std::string("no thread for the run: ") + error.what());
  }
}

void LocalRun::stop() {
  server_->stop();
}

void close_doors(LoadedConfig& loaded) {
  if (loaded.origin["net.listen"] == Origin::kDefault) loaded.config.mutable_net()->set_listen("");
  if (loaded.origin["net.http"] == Origin::kDefault) loaded.config.mutable_net()->set_http("");
}

Result<server::ServerOptions> new_run(LoadedConfig loaded, const fs::path& folder) {
  auto experiment = assets::resolve_experiment(loaded.config, loaded.base);
  if (!experiment) return fail(experiment.error().code, loaded.file + ": " + experiment.error().message);
  for (const std::string& warning : experiment->warnings) warn(warning);
  if (server::Store::holds_run(folder)) {
    const std::string name = folder.string();
    return fail(ErrorCode::kInvalid,
                name + ": holds a run already; go on with it by: evograsp train --resume " + name);
  }
  close_doors(loaded);
  server::ServerOptions prepared;
  prepared.run_dir = folder;
  prepared.config = std::move(loaded.config);
  prepared.experiment = std::move(*experiment);
  return prepared;
}

Result<server::ServerOptions> resumed_run(const fs::path& folder) {
  const auto run = read_run_folder(folder);
  if (!run) return tl::unexpected(run.error());
  server::ServerOptions prepared;
  prepared.run_dir = folder;
  prepared.config = run->info.config;
  prepared.resume = true;
  return prepared;
}

}  // namespace evograsp::cli

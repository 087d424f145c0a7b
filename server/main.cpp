// evograsp-server: the master of a run.
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <new>

#include "common/config.h"
#include "common/last_words.h"
#include "common/log.h"
#include "common/rendezvous.h"
#include "common/signals.h"
#include "common/socket.h"
#include "common/version.h"
#include "common/watchdog.h"
#include "server/server.h"
#include "server/store.h"

namespace {

using namespace evograsp;

constexpr int kInterrupted = 130;

constexpr char kExamples[] =
    "Examples:\n"
    "  evograsp-server --config cube --run-dir runs/cube            then: evograsp-worker on this machine\n"
    "  evograsp-server --config my.txtpb --set neat.population=200 --seed 7\n"
    "  evograsp-server --resume runs/cube                           goes on where it was, to the same bytes\n"
    "  evograsp-server --config cube --run-dir runs/cube --continue  the one or the other (services)\n"
    "  evograsp-server --config cube --listen 'tcp://*:5555' --set net.curve_secret_key_file=master.key \\\n"
    "                  --set net.curve_allow_file=workers.pub       for workers on other machines\n\n"
    "Without workers the run waits for them; they come and go at any time. SIGTERM: commit and exit 130; go "
    "on with\n"
    "--resume. A second signal: exit at once (what is committed stays).\n\n"
    "Exit codes: 0 finished, 130 interrupted and resumable, 2 usage, 3 invalid config or run, 4 not found, 5 "
    "reading or\n"
    "writing failed, 6 address or run in use, 70 a bug.";

struct Flags {
  std::string config, run_dir, resume, listen, http, publish, rendezvous, advertise;
  std::vector<std::string> set;
  std::uint64_t seed = 0;
  bool insecure = false, stay = false, take_up = false;
  LogOptions log;
};

int report(const Error& error) {
  std::fprintf(stderr, "evograsp-server: %s\n", error.message.c_str());
  return static_cast<int>(error.code);
}

std::vector<std::string> overrides(const Flags& flags, bool seed_given) {
  std::vector<std::string> all = flags.set;
  if (seed_given) all.push_back("run.seed=" + std::to_string(flags.seed));
  return all;
}

// What the flags say about addresses; also when resuming, where no config file is read.
proto::NetConfig net_of(const CLI::App& app, const Flags& flags) {
  proto::NetConfig net;
  if (app.count("--listen") > 0) net.set_listen(flags.listen);
  if (app.count("--http") > 0) net.set_http(flags.http);
  if (app.count("--publish") > 0) net.set_publish(flags.publish);
  if (flags.insecure) net.set_insecure(true);
  return net;
}

Status fill_new(const Flags& flags, bool seed_given, server::ServerOptions& options) {
  auto loaded =
      load_config(flags.config, overrides(flags, seed_given),
                  {{"scene.object", assets::object_names()}, {"grasp.hand", assets::builtin_hands()}});
  if (!loaded) {
    for (const Diagnostic& diagnostic : loaded.error())
      std::fprintf(stderr, "%s\n", diagnostic.text().c_str());
    return fail(ErrorCode::kInvalid, flags.config + ": not usable");
  }
  auto experiment = assets::resolve_experiment(loaded->config, loaded->base);
  if (!experiment) return tl::unexpected(experiment.error());
  for (const std::string& warning : experiment->warnings) spdlog::warn("{}", warning);
  options.config = std::move(loaded->config);
  options.experiment = std::move(*experiment);
  options.run_dir = flags.run_dir.empty() ? "runs/" + options.config.run().name() : flags.run_dir;
  return {};
}

std::string host_name() {
  char name[256] = {};
  gethostname(name, sizeof name - 1);
  return name;
}

// Says in a file where the server is, for as long as it is there, and then that the run is over if it is.
class Announcement {
 public:
  Announcement(const Flags& flags, const std::string& http) : file_(flags.rendezvous), http_(http) {
    host_ = flags.advertise.empty() ? host_name() : flags.advertise;
  }
  ~Announcement() {
    if (made_ && !finished_) remove_rendezvous(file_, where_);
    if (!made_ || !finished_) return;
    if (const Status status = end_rendezvous(file_, where_, "the run is finished"); !status)
      spdlog::warn("{}", status.error().message);
  }
  void set_finished() { finished_ = true; }
  Status make(const server::Server& server) {
    if (file_.empty()) return {};
    where_ = {
        advertised(server.endpoints().at(0), host_), advertised_http(http_, server.http_port(), host_), {}};
    const Status status = write_rendezvous(file_, where_);
    made_ = status.has_value();
    return status;
  }

 private:
  const std::string file_, http_;
  std::string host_;
  Rendezvous where_;
  bool made_ = false, finished_ = false;
};

void stay_until(const Wakeup& end) {
  spdlog::info("staying to answer questions; SIGTERM ends it");
  Watchdog watchdog;
  zmq::pollitem_t item{nullptr, end.fd(), ZMQ_POLLIN, 0};
  do watchdog.beat();
  while (zmq::poll(&item, 1, std::chrono::seconds(1)) == 0);
}

// A descriptor a worker, and some for strangers: the customary 1,024 are too few for a cluster.
void allow_many_connections() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

int run(server::ServerOptions options, const Flags& flags, SignalWatch& signals) {
  const std::string run_dir = options.run_dir.string();
  auto made = server::Server::create(std::move(options));
  if (!made) return report(made.error());
  server::Server& server = **made;
  Wakeup end;
  signals.start([&] {
    notify_service_manager("STOPPING=1");
    spdlog::info("stopping: what is done is being committed");
    server.stop();
    end.notify();
  });
  const SignalScope heard(signals);
  for (const std::string& endpoint : server.endpoints()) spdlog::info("workers: {}", endpoint);
  if (server.http_port() != 0) spdlog::info("http: port {}", server.http_port());
  Announcement announcement(flags, server.http_listen());
  if (const Status status = announcement.make(server); !status) return report(status.error());
  notify_service_manager("READY=1");
  const auto state = server.run();
  if (!state) return report(state.error());
  if (*state != server::RunState::kFinished) {
    std::fprintf(stderr, "evograsp-server: interrupted; go on with: evograsp-server --resume %s\n",
                 run_dir.c_str());
    return kInterrupted;
  }
  announcement.set_finished();
  spdlog::info("finished: {}/champion.pb", run_dir);
  if (flags.stay) stay_until(end);
  return 0;
}

int serve(int argc, char** argv) {
  SignalWatch signals;
  CLI::App app("The master of an evograsp run: evolves grasp controllers on workers.", "evograsp-server");
  app.set_version_flag("--version", std::string("evograsp-server ") + kVersion);
  app.footer(kExamples);
  Flags flags;
  auto* config = app.add_option("--config", flags.config, "config file or the name of a built-in one");
  app.add_option("--run-dir", flags.run_dir, "folder of the run (default: runs/ and the config's name)");
  app.add_option("--resume", flags.resume, "go on with the run in this folder")->excludes(config);
  app.add_flag("--continue", flags.take_up, "go on with the run that --run-dir holds already, else begin it");
  app.add_option("--listen", flags.listen, "where workers connect (net.listen), e.g. tcp://127.0.0.1:5555");
  app.add_option("--http", flags.http, "where the HTTP API answers (net.http); empty: nowhere");
  app.add_option("--publish", flags.publish, "where champions are published (net.publish)");
  app.add_option("--rendezvous", flags.rendezvous,
                 "file to say in where the server can be reached (evograsp-worker --rendezvous)");
  app.add_option("--advertise", flags.advertise,
                 "host that --rendezvous names for 'tcp://*:PORT' (default: this host's name)");
  app.add_option("--seed", flags.seed, "the run's seed (run.seed)");
  app.add_option("--set", flags.set, "any value of the config: neat.population=200")->take_all();
  app.add_flag("--insecure", flags.insecure, "listen beyond this machine without keys");
  app.add_flag("--stay", flags.stay, "answer questions after the run has finished, until SIGTERM");
  app.add_flag("--log-json", flags.log.json, "log lines as JSON objects");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ErrorCode::kUsage);
  }
  set_up_logging(flags.log);
  signals.end_at_signal();
  allow_many_connections();
  if (app.count("--listen") > 0 && flags.listen.empty())
    return report({ErrorCode::kUsage, "--listen: wants an address, e.g. tcp://127.0.0.1:5555"});
  server::ServerOptions options;
  options.net = net_of(app, flags);
  if (flags.take_up && flags.run_dir.empty())
    return report({ErrorCode::kUsage, "--continue: --run-dir is wanted; see --help"});
  if (flags.take_up && server::Store::holds_run(flags.run_dir)) flags.resume = flags.run_dir;
  if (!flags.resume.empty()) {
    options.run_dir = flags.resume;
    options.resume = true;
  } else if (flags.config.empty()) {
    return report({ErrorCode::kUsage, "--config or --resume is wanted; see --help"});
  } else if (Status status = fill_new(flags, app.count("--seed") > 0, options); !status) {
    return report(status.error());
  }
  return run(std::move(options), flags, signals);
}

}  // namespace

int main(int argc, char** argv) {
  set_last_words("evograsp-server");
  try {
    return serve(argc, argv);
  } catch (const std::bad_alloc&) {
    return report({ErrorCode::kIo, "not enough memory for this run on this machine"});
  } catch (const std::exception& error) {
    return report(error_of_exception(error));
  }
}

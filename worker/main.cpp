// evograsp-worker: simulator slots for a master.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/last_words.h"
#include "common/log.h"
#include "common/signals.h"
#include "common/version.h"
#include "common/zap.h"
#include "worker/worker.h"

namespace {

using namespace evograsp;

constexpr char kExamples[] =
    "Examples:\n"
    "  evograsp-worker --connect tcp://master:5555            one slot a core, until told to stop\n"
    "  evograsp-worker --rendezvous run/rendezvous --once     finds the master by a shared file, ends with "
    "the run\n"
    "  evograsp-worker --connect tcp://master:5555 --curve-key-file worker.key\n\n"
    "The master may be started later, restarted or moved: the worker keeps looking for it. It needs no "
    "files: objects\n"
    "and hands come from the master. SIGTERM: finish what has started, hand back the rest, exit 0; a second "
    "one: exit at\n"
    "once.\n\n"
    "Exit codes: 0 drained, stopped or run over (--once), 2 usage, 3 or 7 the experiment cannot be simulated "
    "here,\n"
    "6 refused by the master, not drained in time, or no master for --wait-seconds, 70 a bug.";

int report(const Error& error) {
  std::fprintf(stderr, "evograsp-worker: %s\n", error.message.c_str());
  return static_cast<int>(error.code);
}

int serve(const worker::WorkerOptions& options, SignalWatch& signals) {
  auto made = worker::Worker::create(options);
  if (!made) return report(made.error());
  worker::Worker& worker = **made;
  signals.start([&worker] {
    notify_service_manager("STOPPING=1");
    worker.drain();
  });
  const SignalScope heard(signals);
  notify_service_manager("READY=1");
  const Status status = worker.run();
  if (status) return 0;
  const int code = report(status.error());
  // A slot that hangs cannot be joined: leave without it.
  std::fflush(nullptr);
  std::_Exit(code);
}

}  // namespace

int main(int argc, char** argv) {
  set_last_words("evograsp-worker");
  SignalWatch signals;
  CLI::App app("Simulator slots for an evograsp master.", "evograsp-worker");
  app.set_version_flag("--version", std::string("evograsp-worker ") + kVersion);
  app.footer(kExamples);
  worker::WorkerOptions options;
  LogOptions log;
  std::string key_file;
  app.add_option("--connect", options.connect, "where the master listens")
      ->envname("EVOGRASP_CONNECT")
      ->capture_default_str();
  app.add_option(
         "--rendezvous", options.rendezvous,
         "file in which evograsp-server --rendezvous says where it listens; read anew for each connection")
      ->envname("EVOGRASP_RENDEZVOUS")
      ->excludes("--connect");
  app.add_option("--wait-seconds", options.wait_seconds, "end when there is no master for so long; 0: never")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--slots", options.slots, "simulations at a time; 0: one a core")
      ->check(CLI::Range(0, 4096));
  app.add_option(
      "--identity", options.identity,
      "name to the master, unique among its workers, the same after a restart (default: host, machine, "
      "number)");
  app.add_option("--host", options.host,
                 "name of the machine: what one has evaluated is audited on another (default: host name; in "
                 "a container, say its node's)")
      ->envname("EVOGRASP_HOST");
  app.add_option("--curve-key-file", key_file, "key pair and the master's public key: evograsp keygen")
      ->envname("EVOGRASP_CURVE_KEY_FILE");
  app.add_option("--drain-seconds", options.drain_seconds, "time that running tasks get at SIGTERM")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  app.add_option(
      "--alive-file", options.alive_file,
      "file written every second while the worker lives, with what it does: looking, loading, serving "
      "or draining (probes)");
  app.add_flag("--once", options.once, "end when the master's run ends");
  app.add_flag("--log-json", log.json, "log lines as JSON objects");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ErrorCode::kUsage);
  }
  set_up_logging(log);
  if (!key_file.empty()) {
    auto keys = load_keys(key_file);
    if (!keys) return report(keys.error());
    options.curve = std::move(*keys);
  }
  return serve(options, signals);
}

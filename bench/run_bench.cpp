// The thesis's chapter 6 as whole runs (configs/cylinder.txtpb: 60,000 trials): run/inprocess/SLOTS is a
// server and a worker in one process (as `evograsp train`), run/distributed a server process's code with one
// evograsp-worker process over TCP. Trials a second as the counter.
#include <benchmark/benchmark.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <thread>

#include "assets/assets.h"
#include "common/config.h"
#include "common/log.h"
#include "server/server.h"
#include "worker/worker.h"

namespace evograsp {
namespace {

struct Setting {
  proto::Config config;
  assets::ResolvedExperiment experiment;
};

// 120 genomes x 5 trials x 100 generations, everything journalled.
const Setting& setting() {
  static const Setting made = [] {
    spdlog::set_level(spdlog::level::err);
    Setting s;
    s.config = load_config(EVOGRASP_SOURCE_DIR "/configs/cylinder.txtpb",
                           {"net.listen=tcp://127.0.0.1:*", "net.http="})
                   ->config;
    s.experiment = *assets::resolve_experiment(s.config, EVOGRASP_SOURCE_DIR "/configs");
    return s;
  }();
  return made;
}

class RunFolder {
 public:
  RunFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "evograsp-bench-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~RunFolder() { std::filesystem::remove_all(path_); }
  std::filesystem::path run() const { return path_ / "run"; }

 private:
  std::filesystem::path path_;
};

std::unique_ptr<server::Server> make_server(const RunFolder& folder, zmq::context_t* context) {
  server::ServerOptions options;
  options.config = setting().config;
  options.experiment = setting().experiment;
  options.run_dir = folder.run();
  options.context = context;
  return std::move(*server::Server::create(std::move(options)));
}

// From the first generation on, by the server's own clock: loading meshes and joining are not what is
// measured.
struct Clock {
  server::GenerationReport first, last;
  void operator()(const server::GenerationReport& report) {
    if (report.generation == 0) first = report;
    last = report;
  }
  double seconds() const { return last.seconds - first.seconds; }
  std::uint64_t counted() const { return last.trials - first.trials; }
};

void report(benchmark::State& state, std::uint64_t trials, double seconds) {
  state.counters["trials_per_second"] = static_cast<double>(trials) / seconds;
}

void in_process(benchmark::State& state, int slots) {
  std::uint64_t trials = 0;
  double seconds = 0;
  for (auto _ : state) {
    const RunFolder folder;
    zmq::context_t context(1);
    auto server = make_server(folder, &context);
    worker::WorkerOptions options;
    options.connect = "inproc://evograsp";
    options.slots = slots;
    options.context = &context;
    auto worker = std::move(*worker::Worker::create(options));
    std::thread thread([&] { (void)worker->run(); });
    Clock clock;
    server->on_generation([&](const server::GenerationReport& r) { clock(r); });
    (void)server->run();
    worker->stop();
    thread.join();
    trials += clock.counted();
    seconds += clock.seconds();
  }
  report(state, trials, seconds);
}

void distributed(benchmark::State& state) {
  std::uint64_t trials = 0;
  double seconds = 0;
  for (auto _ : state) {
    const RunFolder folder;
    auto server = make_server(folder, nullptr);
    const std::string endpoint = server->endpoints()[0];
    const pid_t child = fork();
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      const std::string program = EVOGRASP_BIN_DIR "/evograsp-worker";
      execl(program.c_str(), program.c_str(), "--connect", endpoint.c_str(), "--slots", "2", "--once",
            nullptr);
      _exit(127);
    }
    Clock clock;
    server->on_generation([&](const server::GenerationReport& r) { clock(r); });
    (void)server->run();
    server.reset();
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    trials += clock.counted();
    seconds += clock.seconds();
  }
  report(state, trials, seconds);
}

void BM_OneSlot(benchmark::State& state) {
  in_process(state, 1);
}
void BM_InProcess(benchmark::State& state) {
  in_process(state, 2);
}
void BM_Distributed(benchmark::State& state) {
  distributed(state);
}
BENCHMARK(BM_OneSlot)->Name("run/oneslot")->Unit(benchmark::kMillisecond);
BENCHMARK(BM_InProcess)->Name("run/inprocess")->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Distributed)->Name("run/distributed")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace evograsp

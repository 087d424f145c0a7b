// What a master adds to an evaluation: dispatch/20k is the real server code (sessions, scheduling, journal,
// scoring) on no-op work; dispatch_floor/20k the least that ROUTER/DEALER and protobuf can do. Two worker
// processes each.
#include <benchmark/benchmark.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "common/cpu_time.h"
#include "common/log.h"
#include "common/wire.h"
#include "score/score.h"
#include "server/dispatcher.h"
#include "server/gather.h"
#include "server/store.h"

namespace evograsp {
namespace {

constexpr std::size_t kNetworkBytes = 20000;
constexpr int kWorkers = 2;
constexpr std::uint32_t kNetworks = 2000;  // a generation

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Child processes that die with this one.
class Children {
 public:
  ~Children() {
    for (const pid_t child : children_) kill(child, SIGKILL);
    for (const pid_t child : children_) waitpid(child, nullptr, 0);
  }
  // In the child `run` must not return.
  template <class F>
  void start(F run) {
    const pid_t pid = fork();
    if (pid != 0) return children_.push_back(pid);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    run();
    _exit(1);
  }

 private:
  std::vector<pid_t> children_;
};

// Rates by the wall clock: this thread mostly waits. (Modifiers of a benchmark would change its name.)
void report(benchmark::State& state, double cpu, double seconds) {
  const auto evaluations = static_cast<double>(state.iterations()) * kNetworks;
  state.counters["evaluations_per_second"] = evaluations / seconds;
  state.counters["master_cpu_us"] = cpu / evaluations * 1e6;
}

// ---- the real thing ----

class NoopServer {
 public:
  NoopServer() : scorer_(*score::Scorer::create(proto::FitnessConfig())) {
    spdlog::set_level(spdlog::level::err);
    std::string name = (std::filesystem::temp_directory_path() / "evograsp-bench-XXXXXX").string();
    folder_ = mkdtemp(name.data());
    server::NewRun run;
    run.info.config.mutable_store()->set_journal_seconds(0.2);
    store_ = std::move(*server::Store::create(folder_ / "run", std::move(run)));
    gather_ = std::make_unique<server::Gather>(scorer_, *store_);
    server::DispatcherOptions options;
    options.endpoints = {"tcp://127.0.0.1:*"};
    options.stamp = {1, 1};
    options.experiment.set_fingerprint("none");
    dispatcher_ = std::move(*server::Dispatcher::create(context_, options, *gather_));
    const std::string endpoint = dispatcher_->endpoints()[0];
    for (int i = 0; i < kWorkers; ++i)
      children_.start([&] {
        const std::string program = EVOGRASP_BIN_DIR "/evograsp-worker";
        execl(program.c_str(), program.c_str(), "--connect", endpoint.c_str(), "--slots", "1", nullptr);
      });
    frame_ = to_frame(std::string(kNetworkBytes, 'n'));
    while (dispatcher_->view().workers.size() < kWorkers) usleep(10000);
  }
  ~NoopServer() {
    dispatcher_.reset();
    store_.reset();
    std::filesystem::remove_all(folder_);
  }

  void generation(std::uint32_t number) {
    std::vector<proto::TrialKey> trials(1);
    std::vector<server::Gather::Item> items(kNetworks);
    for (std::uint32_t i = 0; i < kNetworks; ++i) items[i].genome = i;
    gather_->begin(server::Gather::Kind::kGeneration, number, std::move(items), trials);
    gather_->pending();
    server::Work work;
    work.generation = number;
    work.trial_set = number;
    work.trials = std::move(trials);
    work.networks = kNetworks;
    work.noop_seconds = 0;
    dispatcher_->begin(std::move(work));
    std::vector<server::NetworkFrame> frames;
    for (std::uint32_t i = 0; i < kNetworks; ++i) frames.push_back({i, to_frame(frame_.to_string_view())});
    dispatcher_->add(0, std::move(frames));
    while (!gather_->wait(1)) {
    }
    gather_->take();
  }

 private:
  std::filesystem::path folder_;
  score::Scorer scorer_;
  std::unique_ptr<server::Store> store_;
  std::unique_ptr<server::Gather> gather_;
  zmq::context_t context_{1};
  std::unique_ptr<server::Dispatcher> dispatcher_;
  Children children_;
  zmq::message_t frame_;
};

void BM_Dispatch(benchmark::State& state) {
  NoopServer server;
  std::uint32_t number = 0;
  for (int i = 0; i < 3; ++i) server.generation(number++);
  const double before = process_cpu_seconds(), start = wall_seconds();
  for (auto _ : state) server.generation(number++);
  report(state, process_cpu_seconds() - before, wall_seconds() - start);
}
BENCHMARK(BM_Dispatch)->Name("dispatch/20k")->Unit(benchmark::kMillisecond);

// ---- the floor ----

[[noreturn]] void floor_worker(const std::string& endpoint) {
  zmq::context_t context(1);
  zmq::socket_t socket(context, zmq::socket_type::dealer);
  socket.connect(endpoint);
  socket.send(zmq::str_buffer("ready"));
  proto::Envelope answer = make_envelope({1, 1});
  answer.mutable_result()->add_measurement();
  for (;;) {
    zmq::message_t head;
    if (!socket.recv(head)) _exit(0);
    proto::Envelope envelope;
    envelope.ParseFromArray(head.data(), static_cast<int>(head.size()));
    answer.mutable_result()->set_id(envelope.task().id());
    socket.send(to_frame(answer), zmq::send_flags::none);
  }
}

void BM_Floor(benchmark::State& state) {
  Children children;
  char endpoint[64];
  {
    zmq::context_t probe(1);
    zmq::socket_t socket(probe, zmq::socket_type::router);
    socket.bind("tcp://127.0.0.1:*");
    std::snprintf(endpoint, sizeof endpoint, "%s", socket.get(zmq::sockopt::last_endpoint).c_str());
  }
  for (int i = 0; i < kWorkers; ++i) children.start([&] { floor_worker(endpoint); });
  zmq::context_t context(1);
  zmq::socket_t router(context, zmq::socket_type::router);
  router.set(zmq::sockopt::linger, 0);
  router.bind(endpoint);
  const std::string network(kNetworkBytes, 'n');
  proto::Envelope task = make_envelope({1, 1});
  task.mutable_task()->add_trial();
  std::uint64_t next = 0;
  const auto give = [&](const std::string& peer) {
    task.mutable_task()->set_id(++next);
    send(router, peer, to_frame(task, {network}));
  };
  const auto take = [&](zmq::message_t& peer) {
    zmq::message_t head;
    if (!router.recv(peer) || !router.recv(head)) return;
    proto::Envelope envelope;
    if (head.to_string_view() != "ready") envelope.ParseFromArray(head.data(), static_cast<int>(head.size()));
    benchmark::DoNotOptimize(envelope);
  };
  constexpr int kCredit = 8;
  for (int i = 0; i < kWorkers; ++i) {
    zmq::message_t peer;
    take(peer);
    for (int c = 0; c < kCredit; ++c) give(peer.to_string());
  }
  const double before = process_cpu_seconds(), start = wall_seconds();
  for (auto _ : state)
    for (std::uint32_t i = 0; i < kNetworks; ++i) {
      zmq::message_t peer;
      take(peer);
      give(peer.to_string());
    }
  report(state, process_cpu_seconds() - before, wall_seconds() - start);
}
BENCHMARK(BM_Floor)->Name("dispatch_floor/20k")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace evograsp

#include "cli/bench_workers.h"

#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <deque>
#include <queue>
#include <vector>

#include "common/random.h"
#include "common/version.h"
#include "common/wire.h"

namespace evograsp::cli {
namespace {

constexpr int kEventsATurn = 512;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct FakeTask {
  std::uint64_t id = 0;
  std::uint32_t attempt = 0, trials = 0;
  std::vector<std::uint64_t> networks;
  double came = 0, seconds = 0;
};

struct FakeWorker {
  zmq::socket_t socket;
  SessionStamp stamp;
  bool ready = false;
  int idle = 0;  // slots
  std::deque<FakeTask> queue;
};

// A slot that will be done.
struct End {
  double at = 0;
  std::uint32_t worker = 0;
  double began = 0;
  std::uint32_t task = 0;  // of running_
  bool operator>(const End& other) const { return at > other.at; }
};

class FakeWorkersImpl : public FakeWorkers {
 public:
  explicit FakeWorkersImpl(const FakeWorkersOptions& options)
      : options_(options), context_(1), epoll_(epoll_create1(EPOLL_CLOEXEC)) {
    context_.set(zmq::ctxopt::max_sockets, options.workers + 16);
  }
  ~FakeWorkersImpl() override { close(epoll_); }

  Status open() {
    SocketOptions socket_options;
    socket_options.curve = options_.curve;
    workers_.resize(static_cast<std::size_t>(options_.workers));
    for (std::uint32_t i = 0; i < workers_.size(); ++i) {
      auto socket = make_dealer(context_, options_.connect, socket_options);
      if (!socket) return tl::unexpected(socket.error());
      workers_[i].socket = std::move(*socket);
      workers_[i].idle = options_.slots;
      epoll_event event{};
      event.events = EPOLLIN | EPOLLET;
      event.data.u32 = i;
      if (epoll_ctl(epoll_, EPOLL_CTL_ADD, workers_[i].socket.get(zmq::sockopt::fd), &event) != 0)
        return fail(ErrorCode::kIo, std::string("epoll: ") + std::strerror(errno));
      say_hello(i);
      read_all(i);
    }
    reset();
    return {};
  }

  void serve(double seconds) override {
    const double until = now() + seconds;
    for (double time = now(); time < until; time = now()) {
      const double next = ends_.empty() ? until : std::min(until, ends_.top().at);
      const int patience = std::clamp(static_cast<int>((next - time) * 1000), 0, 100);
      epoll_event events[kEventsATurn];
      const int count = epoll_wait(epoll_, events, kEventsATurn, patience);
      for (int i = 0; i < count; ++i) read_all(events[i].data.u32);
      finish_until(now());
    }
  }

  int ready() const override {
    return static_cast<int>(
        std::count_if(workers_.begin(), workers_.end(), [](const auto& w) { return w.ready; }));
  }
  void reset() override {
    figures_ = {};
    since_ = now();
  }
  FakeWorkersFigures figures() const override {
    FakeWorkersFigures seen = figures_;
    const double time = now();
    seen.seconds = time - since_;
    // What is under way counts as far as it has come.
    auto running = ends_;
    for (; !running.empty(); running.pop()) seen.busy_seconds += part(running.top(), time);
    return seen;
  }

 private:
  double part(const End& end, double time) const {
    return std::max(0.0, std::min(end.at, time) - std::max(end.began, since_));
  }

  void say_hello(std::uint32_t i) {
    proto::Envelope envelope = make_envelope({});
    proto::Hello& hello = *envelope.mutable_hello();
    hello.set_build(kVersion);
    hello.set_host("bench");
    hello.set_pid(static_cast<std::uint32_t>(getpid()));
    hello.set_slots(static_cast<std::uint32_t>(options_.slots));
    hello.set_identity("bench-" + std::to_string(i));
    send(workers_[i].socket, {}, envelope);
  }

  // The descriptor of a ZeroMQ socket tells only somebody who has found it empty: everything must be read, at
  // the start and after each send.
  void read_all(std::uint32_t i) {
    Received message;
    while (receive(workers_[i].socket, false, arena_, message)) {
      if (message.envelope != nullptr) handle(i, *message.envelope);
      message.envelope = nullptr;
      arena_.Reset();
    }
  }

  void handle(std::uint32_t i, const proto::Envelope& envelope) {
    FakeWorker& worker = workers_[i];
    if (envelope.has_welcome()) {
      worker.stamp = {envelope.run(), envelope.epoch()};
      proto::Envelope answer = make_envelope(worker.stamp);
      answer.mutable_ready()->set_fingerprint(envelope.welcome().experiment().fingerprint());
      send(worker.socket, {}, answer);
      worker.ready = true;
    } else if (envelope.has_task()) {
      enqueue(i, envelope.task());
    } else if (envelope.has_heartbeat()) {
      proto::Envelope answer = make_envelope(worker.stamp);
      *answer.mutable_heartbeat() = envelope.heartbeat();
      send(worker.socket, {}, answer);
    } else if (envelope.has_refusal()) {
      worker.ready = false;
    }
  }

  double draw() {
    switch (options_.times) {
      case WorkTimes::kUniform:
        return 2 * options_.mean_seconds * random_.uniform();
      case WorkTimes::kExponential:
        return -options_.mean_seconds * std::log1p(-random_.uniform());
      default:
        return options_.mean_seconds;
    }
  }

  void enqueue(std::uint32_t i, const proto::Task& task) {
    FakeTask fake;
    fake.id = task.id();
    fake.attempt = task.attempt();
    fake.trials = static_cast<std::uint32_t>(task.trial_size());
    fake.networks.assign(task.network().begin(), task.network().end());
    fake.came = now();
    for (std::size_t n = 0; n < fake.networks.size() * fake.trials; ++n) fake.seconds += draw();
    FakeWorker& worker = workers_[i];
    if (worker.idle > 0) {
      --worker.idle;
      begin(i, std::move(fake), 0);
    } else {
      worker.queue.push_back(std::move(fake));
    }
  }

  void begin(std::uint32_t i, FakeTask task, double slot_free) {
    const double began = std::max(task.came, slot_free);
    std::uint32_t place = 0;
    if (free_.empty()) {
      place = static_cast<std::uint32_t>(running_.size());
      running_.emplace_back();
    } else {
      place = free_.back();
      free_.pop_back();
    }
    ends_.push({began + task.seconds, i, began, place});
    running_[place] = std::move(task);
  }

  void finish_until(double time) {
    while (!ends_.empty() && ends_.top().at <= time) {
      const End end = ends_.top();
      ends_.pop();
      figures_.busy_seconds += part(end, time);
      figures_.worst_late = std::max(figures_.worst_late, time - end.at);
      ++figures_.tasks;
      answer(end);
      FakeWorker& worker = workers_[end.worker];
      free_.push_back(end.task);
      if (worker.queue.empty()) {
        ++worker.idle;
      } else {
        FakeTask next = std::move(worker.queue.front());
        worker.queue.pop_front();
        begin(end.worker, std::move(next), end.at);
      }
      read_all(end.worker);
    }
  }

  void answer(const End& end) {
    const FakeTask& task = running_[end.task];
    proto::Envelope envelope = make_envelope(workers_[end.worker].stamp);
    proto::TaskResult& result = *envelope.mutable_result();
    result.set_id(task.id);
    result.set_attempt(task.attempt);
    for (const std::uint64_t network : task.networks) result.add_network(network);
    for (std::size_t n = 0; n < task.networks.size() * task.trials; ++n)
      result.add_measurement()->set_outcome(proto::MISSED);
    result.set_wall_nanoseconds(static_cast<std::uint64_t>(task.seconds * 1e9));
    send(workers_[end.worker].socket, {}, envelope);
  }

  const FakeWorkersOptions options_;
  zmq::context_t context_;
  const int epoll_;
  std::vector<FakeWorker> workers_;
  std::priority_queue<End, std::vector<End>, std::greater<>> ends_;
  std::vector<FakeTask> running_;
  std::vector<std::uint32_t> free_;  // places in running_
  google::protobuf::Arena arena_;
  Random random_{1, Purpose::kTestHarness};
  FakeWorkersFigures figures_;
  double since_ = 0;
};

}  // namespace

Result<std::unique_ptr<FakeWorkers>> FakeWorkers::create(const FakeWorkersOptions& options) {
  auto workers = std::make_unique<FakeWorkersImpl>(options);
  if (Status status = workers->open(); !status) return tl::unexpected(status.error());
  return workers;
}

}  // namespace evograsp::cli

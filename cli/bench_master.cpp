#include "cli/bench_master.h"

#include <signal.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

#include "cli/bench_genome.h"
#include "common/cpu_time.h"
#include "common/zap.h"
#include "score/score.h"
#include "server/dispatcher.h"
#include "server/gather.h"
#include "server/store.h"

namespace evograsp::cli {
namespace {

constexpr std::uint64_t kSomeSeed = 0x9e3779b97f4a7c15;

enum Order : char { kBegin = 'b', kFigures = 'f' };

// What the child says once it listens, or why it does not.
struct Hello {
  bool listens = false;
  std::array<char, 256> text{};
};

bool read_whole(int fd, void* data, std::size_t size) {
  return recv(fd, data, size, MSG_WAITALL) == static_cast<ssize_t>(size);
}
bool write_whole(int fd, const void* data, std::size_t size) {
  return send(fd, data, size, MSG_NOSIGNAL) == static_cast<ssize_t>(size);
}

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

// ---- in the child ----

class Child {
 public:
  explicit Child(const BenchMasterOptions& options) : options_(options) {}
  ~Child() {
    dispatcher_.reset();
    store_.reset();
    std::error_code problem;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, problem);
  }

  Result<std::string> open() {
    auto genome = bench_genome(options_.genome_bytes);
    if (!genome) return tl::unexpected(genome.error());
    genome_ = std::move(*genome);
    std::string name = (std::filesystem::temp_directory_path() / "evograsp-bench-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) return fail(ErrorCode::kIo, name + ": " + std::strerror(errno));
    folder_ = name;
    auto store = server::Store::create(folder_ / "run", {});
    if (!store) return tl::unexpected(store.error());
    store_ = std::move(*store);
    auto scorer = score::Scorer::create(proto::FitnessConfig());
    if (!scorer) return tl::unexpected(scorer.error());
    scorer_ = *scorer;
    gather_ = std::make_unique<server::Gather>(*scorer_, *store_);
    server::DispatcherOptions options;
    options.endpoints = {"tcp://127.0.0.1:*"};
    options.stamp = {1, 1};
    options.experiment.set_fingerprint("none");
    options.scheduler.task_seconds = 1e-6;  // one evaluation a task
    options.scheduler.credit = options_.credit;
    if (options_.curve) {
      options.socket.curve = options_.curve;
      auto gatekeeper = Gatekeeper::create(context_, std::set<std::string>{options_.allowed_key});
      if (!gatekeeper) return tl::unexpected(gatekeeper.error());
      gatekeeper_ = std::move(*gatekeeper);
    }
    auto dispatcher = server::Dispatcher::create(context_, options, *gather_);
    if (!dispatcher) return tl::unexpected(dispatcher.error());
    dispatcher_ = std::move(*dispatcher);
    return dispatcher_->endpoints()[0];
  }

  void begin_work() {
    std::vector<proto::TrialKey> trials(options_.trials);
    for (std::uint32_t i = 0; i < options_.trials; ++i) trials[i].set_seed(kSomeSeed * (i + 1));
    std::vector<server::Gather::Item> items(options_.evaluations);
    for (std::uint32_t i = 0; i < options_.evaluations; ++i) items[i].genome = i;
    gather_->begin(server::Gather::Kind::kGeneration, 0, std::move(items), trials);
    gather_->pending();
    server::Work work;
    work.trials = std::move(trials);
    work.networks = options_.evaluations;
    work.noop_seconds = 0;
    dispatcher_->begin(std::move(work));
    frame_ = to_frame(genome_.packed);
    std::vector<server::NetworkFrame> frames;
    for (std::uint32_t i = 0; i < options_.evaluations; ++i) frames.push_back({i, share(frame_)});
    dispatcher_->add(0, std::move(frames));
  }

  BenchMasterFigures figures() const {
    const server::DispatchView view = dispatcher_->view();
    BenchMasterFigures f;
    f.cpu_seconds = process_cpu_seconds();
    f.resident_bytes = resident_bytes();
    f.seconds = view.seconds;
    f.evaluations = view.evaluations;
    f.lost_workers = view.lost;
    f.refused = view.refused + view.malformed;
    f.workers = view.workers.size();
    f.tasks = view.tasks_done;
    f.genome_bytes = genome_.genome_bytes;
    f.network_bytes = genome_.network_bytes;
    f.packed_bytes = genome_.packed.size();
    f.bytes_sent = view.bytes_sent;
    f.bytes_received = view.bytes_received;
    return f;
  }

 private:
  const BenchMasterOptions& options_;
  std::filesystem::path folder_;
  std::optional<score::Scorer> scorer_;
  std::unique_ptr<server::Store> store_;
  std::unique_ptr<server::Gather> gather_;
  zmq::context_t context_{1};
  std::unique_ptr<Gatekeeper> gatekeeper_;
  std::unique_ptr<server::Dispatcher> dispatcher_;
  BenchGenome genome_;
  zmq::message_t frame_;
};

[[noreturn]] void run_child(const BenchMasterOptions& options, int fd) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  spdlog::set_level(spdlog::level::off);
  {
    Child child(options);
    const auto endpoint = child.open();
    Hello hello;
    hello.listens = endpoint.has_value();
    (endpoint ? *endpoint : endpoint.error().message).copy(hello.text.data(), hello.text.size() - 1);
    write_whole(fd, &hello, sizeof hello);
    for (char order = 0; endpoint && read_whole(fd, &order, 1);) {
      if (order == kBegin) child.begin_work();
      const BenchMasterFigures figures = order == kFigures ? child.figures() : BenchMasterFigures{};
      if (!write_whole(fd, &figures, sizeof figures)) break;
    }
  }
  _exit(0);
}

// ---- in the parent ----

class BenchMasterProcess : public BenchMaster {
 public:
  BenchMasterProcess(pid_t child, int fd) : child_(child), fd_(fd) {}
  ~BenchMasterProcess() override {
    close(fd_);
    waitpid(child_, nullptr, 0);
  }
  Status meet() {
    Hello hello;
    if (!read_whole(fd_, &hello, sizeof hello)) return fail(ErrorCode::kInternal, "bench: the master died");
    if (!hello.listens) return fail(ErrorCode::kUnavailable, std::string("bench: ") + hello.text.data());
    endpoint_ = hello.text.data();
    return {};
  }
  const std::string& endpoint() const override { return endpoint_; }
  Status begin_work() override {
    const auto done = ask(kBegin);
    if (!done) return tl::unexpected(done.error());
    return {};
  }
  Result<BenchMasterFigures> figures() override { return ask(kFigures); }

 private:
  Result<BenchMasterFigures> ask(char order) {
    BenchMasterFigures figures;
    if (write_whole(fd_, &order, 1) && read_whole(fd_, &figures, sizeof figures)) return figures;
    return fail(ErrorCode::kInternal, "bench: the master died");
  }
  const pid_t child_;
  const int fd_;
  std::string endpoint_;
};

}  // namespace

Result<std::unique_ptr<BenchMaster>> BenchMaster::start(const BenchMasterOptions& options) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return fail(ErrorCode::kIo, std::string("bench: ") + std::strerror(errno));
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    run_child(options, ends[1]);
  }
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    return fail(ErrorCode::kIo, std::string("bench: ") + std::strerror(errno));
  }
  auto master = std::make_unique<BenchMasterProcess>(child, ends[0]);
  if (Status status = master->meet(); !status) return tl::unexpected(status.error());
  return master;
}

}  // namespace evograsp::cli

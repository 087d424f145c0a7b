// `evograsp bench dispatch`: how many slots does one master keep busy here?
#include <sys/resource.h>

#include <cmath>
#include <map>
#include <zmq.hpp>

#include "cli/bench.h"
#include "cli/bench_master.h"
#include "cli/bench_workers.h"
#include "cli/output.h"
#include "cli/report.h"

namespace evograsp::cli {
namespace {

constexpr double kWarmUp = 1.0;       // s
constexpr double kMostPatience = 60;  // s for all workers to connect
constexpr std::uint32_t kMostEvaluations = 4'000'000;
constexpr rlim_t kDescriptorsAside = 256;

struct DispatchOptions {
  FakeWorkersOptions workers;
  BenchMasterOptions master;
  double task_ms = 5, seconds = 5;
  bool curve = false, json = false;
};

struct DispatchFigures {
  FakeWorkersFigures workers;
  BenchMasterFigures master;  // differences; memory and workers at the end
  std::int64_t grown_bytes = 0;
  double busy = 0;  // share
};

// Two descriptors a simulated worker, one a connection at the master.
Status allow_descriptors(int workers) {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const rlim_t wanted = 2 * static_cast<rlim_t>(workers) + kDescriptorsAside;
  if (limit.rlim_cur >= wanted) return {};
  limit.rlim_cur = std::min(wanted, limit.rlim_max);
  if (limit.rlim_max >= wanted && setrlimit(RLIMIT_NOFILE, &limit) == 0) return {};
  return fail(ErrorCode::kUnavailable, "bench: " + std::to_string(workers) + " workers need " +
                                           std::to_string(wanted) + " open files, allowed are " +
                                           std::to_string(limit.rlim_max) + ": raise ulimit -n");
}

Result<CurveKeys> new_keys(const std::string& server_key) {
  char public_key[41], secret_key[41];
  if (zmq_curve_keypair(public_key, secret_key) != 0)
    return fail(ErrorCode::kUnsupported, "this libzmq was built without CURVE");
  return CurveKeys{public_key, secret_key, server_key};
}

Status add_keys(DispatchOptions& options) {
  auto server = new_keys("");
  if (!server) return tl::unexpected(server.error());
  auto worker = new_keys(server->public_key);
  if (!worker) return tl::unexpected(worker.error());
  options.master.curve = *server;
  options.master.allowed_key = worker->public_key;
  options.workers.curve = *worker;
  return {};
}

Result<DispatchFigures> measure(BenchMaster& master, FakeWorkers& workers, const DispatchOptions& options) {
  for (double waited = 0; workers.ready() < options.workers.workers; waited += 0.1) {
    if (waited > kMostPatience)
      return fail(ErrorCode::kUnavailable,
                  "bench: only " + std::to_string(workers.ready()) + " workers connected");
    workers.serve(0.1);
  }
  if (Status status = master.begin_work(); !status) return tl::unexpected(status.error());
  workers.serve(kWarmUp);
  const auto before = master.figures();
  if (!before) return tl::unexpected(before.error());
  workers.reset();
  workers.serve(options.seconds);
  DispatchFigures seen;
  seen.workers = workers.figures();
  const auto after = master.figures();
  if (!after) return tl::unexpected(after.error());
  seen.master = *after;
  seen.master.seconds -= before->seconds;
  seen.master.cpu_seconds -= before->cpu_seconds;
  seen.master.evaluations -= before->evaluations;
  seen.master.tasks -= before->tasks;
  seen.master.bytes_sent -= before->bytes_sent;
  seen.master.bytes_received -= before->bytes_received;
  seen.grown_bytes =
      static_cast<std::int64_t>(after->resident_bytes) - static_cast<std::int64_t>(before->resident_bytes);
  seen.busy =
      seen.workers.busy_seconds / (seen.workers.seconds * options.workers.workers * options.workers.slots);
  return seen;
}

nlohmann::ordered_json document(const DispatchOptions& options, const DispatchFigures& seen) {
  const double evaluations = std::max<double>(1, static_cast<double>(seen.master.evaluations));
  const double tasks = std::max<double>(1, static_cast<double>(seen.master.tasks));
  const double counted = std::max(1e-3, seen.master.seconds),
               share = seen.master.cpu_seconds / seen.workers.seconds;
  return {{"workers", options.workers.workers},
          {"slots", options.workers.slots},
          {"task_ms", options.task_ms},
          {"trials", options.master.trials},
          {"genome_bytes", seen.master.genome_bytes},
          {"network_bytes", seen.master.network_bytes},
          {"packed_bytes", seen.master.packed_bytes},
          {"credit", options.master.credit},
          {"curve", options.curve},
          {"seconds", seen.workers.seconds},
          {"busy_share", seen.busy},
          {"evaluations_per_second", static_cast<double>(seen.master.evaluations) / counted},
          {"master_cpu_us", share * counted / evaluations * 1e6},
          {"tasks_per_second", static_cast<double>(seen.master.tasks) / counted},
          {"master_cpu_us_a_task", share * counted / tasks * 1e6},
          {"master_cpu_share", share},
          {"bytes_sent", static_cast<double>(seen.master.bytes_sent) / evaluations},
          {"bytes_received", static_cast<double>(seen.master.bytes_received) / evaluations},
          {"bytes_sent_a_task", static_cast<double>(seen.master.bytes_sent) / tasks},
          {"resident_bytes", seen.master.resident_bytes},
          {"grown_bytes", seen.grown_bytes},
          {"workers_at_the_end", seen.master.workers},
          {"workers_lost", seen.master.lost_workers},
          {"refused", seen.master.refused},
          {"generator_late_ms", seen.workers.worst_late * 1000}};
}

const char* plural(std::int64_t count) {
  return count == 1 ? "" : "s";
}

std::string text(const DispatchOptions& options, const DispatchFigures& seen) {
  const auto j = document(options, seen);
  const auto number = [&](const char* name) { return j[name].get<double>(); };
  char line[1024];
  std::snprintf(
      line, sizeof line,
      "%d worker%s x %d slot%s, %g ms a task, %u task%s an evaluation, credit %u%s\n"
      "genome      %.0f B, its network %.0f B as protobuf, %.0f B as it travels\n"
      "busy        %.1f %% of the slots' time\n"
      "master      %.0f tasks/s, %.1f us CPU each, %.0f MB resident (%+.1f MB)\n"
      "bytes       %.0f out and %.0f in an evaluation\n"
      "workers     %.0f connected, %.0f lost, %.0f refused; the generator was late by %.1f ms at most\n",
      options.workers.workers, plural(options.workers.workers), options.workers.slots,
      plural(options.workers.slots), options.task_ms, options.master.trials, plural(options.master.trials),
      options.master.credit, options.curve ? ", CURVE" : "", number("genome_bytes"), number("network_bytes"),
      number("packed_bytes"), 100 * seen.busy, number("tasks_per_second"), number("master_cpu_us_a_task"),
      number("resident_bytes") / 1e6, number("grown_bytes") / 1e6, number("bytes_sent"),
      number("bytes_received"), number("workers_at_the_end"), number("workers_lost"), number("refused"),
      number("generator_late_ms"));
  return line;
}

int dispatch(DispatchOptions options) {
  if (options.curve)
    if (const Status status = add_keys(options); !status) return report(status.error());
  options.workers.mean_seconds = options.task_ms / 1000;
  const double rate =
      options.workers.workers * options.workers.slots / std::max(1e-4, options.workers.mean_seconds);
  // Enough for the whole time, also when short times come up more often than not; never so much that it does
  // not fit.
  options.master.evaluations = static_cast<std::uint32_t>(std::min<double>(
      kMostEvaluations, 1000 + 1.3 * rate * (options.seconds + kWarmUp) / options.master.trials));
  if (const Status status = allow_descriptors(options.workers.workers); !status)
    return report(status.error());
  const auto master = BenchMaster::start(options.master);
  if (!master) return report(master.error());
  options.workers.connect = (*master)->endpoint();
  const auto workers = FakeWorkers::create(options.workers);
  if (!workers) return report(workers.error());
  const auto seen = measure(**master, **workers, options);
  if (!seen) return report(seen.error());
  if (options.json) {
    print_json(document(options, *seen));
  } else {
    print(text(options, *seen));
  }
  return kExitOk;
}

void add_dispatch(CLI::App& bench, Outcome& outcome) {
  const auto options = std::make_shared<DispatchOptions>();
  CLI::App* sub = bench.add_subcommand(
      "dispatch", "how many slots one master keeps busy: simulated workers, real sockets");
  sub->add_option("--workers", options->workers.workers, "simulated workers, a connection each")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--slots", options->workers.slots, "slots of each")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  sub->add_option("--task-ms", options->task_ms, "what a task takes, on average")
      ->check(CLI::Range(0.01, 1e6))
      ->capture_default_str();
  static const std::map<std::string, WorkTimes> kTimes{{"fixed", WorkTimes::kFixed},
                                                       {"uniform", WorkTimes::kUniform},
                                                       {"exponential", WorkTimes::kExponential}};
  sub->add_option("--times", options->workers.times, "fixed, uniform (0 to twice the mean) or exponential")
      ->transform(CLI::CheckedTransformer(kTimes))
      ->default_str("fixed");
  sub->add_option("--genome-bytes", options->master.genome_bytes, "size of a genotype as protobuf")
      ->check(CLI::Range(500, 1 << 20))
      ->capture_default_str();
  sub->add_option("--trials", options->master.trials, "trials of an evaluation, a task each")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--credit", options->master.credit, "tasks in flight a slot (dispatch.credit)")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--seconds", options->seconds, "how long to measure")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  sub->add_flag("--curve", options->curve, "encrypted, as beyond one machine");
  sub->add_flag("--json", options->json, "answer as JSON");
  sub->footer(
      "Master and simulated workers share this machine's cores. A slot that has its next task in time begins "
      "it at once,\n"
      "however late the generator comes to look: what is idle is the master's doing. Read figures of "
      "docs/SIZING.md so.\n\n"
      "Examples:\n"
      "  evograsp bench dispatch --workers 1000 --task-ms 50\n"
      "  evograsp bench dispatch --workers 100 --task-ms 5 --times exponential --curve --json | jq "
      ".busy_share");
  sub->callback([options, &outcome] { outcome.exit_code = dispatch(*options); });
}

}  // namespace

void add_bench(CLI::App& app, Outcome& outcome) {
  CLI::App* sub = app.add_subcommand("bench", "measure this machine");
  sub->require_subcommand(1);
  sub->footer("Example:\n  evograsp bench dispatch --workers 100 --task-ms 5");
  add_dispatch(*sub, outcome);
}

}  // namespace evograsp::cli

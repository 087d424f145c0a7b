#include "server/metrics.h"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <system_error>
#include <utility>
#include <vector>

#include "common/version.h"
#include "server/api_json.h"

namespace evograsp::server {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricType;

struct Sample {
  const char* label_value;
  double value;
};

class Page {
 public:
  void gauge(const char* name, const char* help, double value) {
    add(name, help, MetricType::Gauge, nullptr, {{"", value}});
  }
  void counter(const char* name, const char* help, std::uint64_t value) {
    add(name, help, MetricType::Counter, nullptr, {{"", static_cast<double>(value)}});
  }
  void add(const char* name, const char* help, MetricType type, const char* label,
           std::vector<Sample> samples) {
    prometheus::MetricFamily family{std::string("evograsp_") + name, help, type, {}};
    for (const Sample& sample : samples) {
      ClientMetric metric;
      if (label != nullptr) metric.label.push_back({label, sample.label_value});
      (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = sample.value;
      family.metric.push_back(std::move(metric));
    }
    families_.push_back(std::move(family));
  }
  std::string text() const { return prometheus::TextSerializer().Serialize(families_); }

 private:
  std::vector<prometheus::MetricFamily> families_;
};

double real(std::uint64_t value) {
  return static_cast<double>(value);
}

void add_run(Page& page, const RunSnapshot& s) {
  page.add("build_info", "Version of the server.", MetricType::Gauge, "version", {{kVersion, 1}});
  std::vector<Sample> states;
  for (const RunState state :
       {RunState::kRunning, RunState::kPaused, RunState::kFinished, RunState::kStopped, RunState::kFailed})
    states.push_back({to_string(state), s.state == state ? 1.0 : 0.0});
  page.add("run_state", "1 for the state the run is in.", MetricType::Gauge, "state", states);
  page.gauge("start_time_seconds", "Unix time at which this process took the run up.", s.started_at);
  page.gauge("epoch", "How often a server has taken the run up.", real(s.epoch));
  page.gauge("generation", "Generation being evaluated, from 0.", s.generation);
  page.gauge("generations_planned", "Generations that the run is to evaluate.", s.generations);
  page.gauge("run_seconds", "Wall time of the run so far, resumed parts included.", s.seconds);
  if (s.committed > 0) {
    page.gauge("fitness_best", "Best fitness of the last judged generation.", s.best);
    page.gauge("fitness_mean", "Mean fitness of the last judged generation.", s.mean);
    page.gauge("fitness_best_ever", "Best fitness of any judged generation.", s.best_ever);
    page.gauge("compatibility_threshold", "Distance at which a genome founds another species.", s.threshold);
  }
  page.gauge("species", "Species of the last judged generation.", real(s.species.size()));
  page.gauge("evaluations_pending", "Evaluations of this generation still to come.",
             real(s.evaluations_total - std::min(s.evaluations_done, s.evaluations_total)));
}

void add_counters(Page& page, const RunCounters& c) {
  page.counter("evaluations_total", "Evaluations accepted by this process.", c.evaluations);
  page.counter("trials_total", "Trials accepted by this process.", c.trials);
  page.add("tasks_total", "Tasks by what became of them.", MetricType::Counter, "event",
           {{"sent", real(c.tasks_sent)},
            {"done", real(c.tasks_done)},
            {"requeued", real(c.tasks_requeued)},
            {"speculated", real(c.tasks_speculated)}});
  page.add("results_ignored_total", "Results that came too late or twice.", MetricType::Counter, "reason",
           {{"late", real(c.results_late)}, {"duplicate", real(c.results_duplicate)}});
  page.counter("frames_refused_total", "Frames that did not parse, were too large or out of order.",
               c.frames_refused);
  page.counter("hellos_refused_total", "Workers refused: version, fingerprint or identity.",
               c.hellos_refused);
  page.counter("workers_lost_total", "Workers that fell silent.", c.workers_lost);
  page.counter("workers_quarantined_total", "Workers whose results differed.", c.workers_quarantined);
  page.counter("audits_total", "Tasks run a second time to compare.", c.audits);
  page.counter("audit_mismatches_total", "Audits that differed.", c.audit_mismatches);
  page.counter("genomes_poisoned_total", "Genomes scored zero because they stopped workers.",
               c.genomes_poisoned);
  page.add("network_bytes_total", "Bytes exchanged with workers.", MetricType::Counter, "direction",
           {{"sent", real(c.bytes_sent)}, {"received", real(c.bytes_received)}});
}

void add_workers(Page& page, const RunSnapshot& s) {
  std::vector<Sample> by_state{{"active", 0}, {"draining", 0}, {"quarantined", 0}, {"gone", 0}};
  double slots = 0, busy = 0;
  for (const WorkerView& w : s.workers) {
    for (Sample& sample : by_state)
      if (w.state == sample.label_value) ++sample.value;
    if (w.state != "active" && w.state != "draining") continue;
    slots += w.slots;
    busy += std::min(w.busy, w.slots);
  }
  page.add("workers", "Workers by state.", MetricType::Gauge, "state", by_state);
  page.add("slots", "Simulator slots of the workers here now.", MetricType::Gauge, "state",
           {{"busy", busy}, {"idle", slots - busy}});
  page.gauge("slots_wanted", "Slots that the run could keep busy four fifths of the time; 0: not known yet.",
             real(s.slots_wanted));
}

void add_store(Page& page, const StoreFigures& f) {
  page.counter("store_evaluations_total", "Evaluations journalled.", f.evaluations);
  page.counter("store_transactions_total", "Transactions of run.db.", f.transactions);
  page.counter("store_commits_total", "Generations committed by this process.", f.commits);
  page.add("store_commit_seconds_total", "Time spent committing generations, sync included.",
           MetricType::Counter, nullptr, {{"", f.total_commit_seconds}});
  page.gauge("store_last_commit_seconds", "Time the last generation took to commit.", f.last_commit_seconds);
  page.gauge("store_queued_bytes", "Waiting to be written.", real(f.queued_bytes));
  page.gauge("store_file_bytes", "Size of run.db.", real(f.file_bytes));
}

void add_process(Page& page) {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  page.add("process_cpu_seconds_total", "CPU time of the server.", MetricType::Counter, "mode",
           {{"user", seconds(usage.ru_utime)}, {"system", seconds(usage.ru_stime)}});
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key; status.ignore(4096, '\n')) {
    double value = 0;
    if (key == "VmRSS:" && status >> value)
      page.gauge("process_resident_bytes", "Memory of the server.", 1024 * value);
    if (key == "Threads:" && status >> value) page.gauge("process_threads", "Threads of the server.", value);
  }
  std::error_code problem;
  std::filesystem::directory_iterator descriptors("/proc/self/fd", problem);
  if (!problem)
    page.gauge("process_open_descriptors", "Open files and sockets of the server.",
               static_cast<double>(std::distance(begin(descriptors), end(descriptors))));
}

}  // namespace

std::string metrics_text(const RunSnapshot& snapshot, const HttpCounts& http,
                         const Strangers::Counts& refused) {
  Page page;
  add_run(page, snapshot);
  add_counters(page, snapshot.counters);
  add_workers(page, snapshot);
  add_store(page, snapshot.store);
  page.add("http_answers_total", "Answers of the HTTP API by class.", MetricType::Counter, "code",
           {{"2xx", real(http[2])}, {"3xx", real(http[3])}, {"4xx", real(http[4])}, {"5xx", real(http[5])}});
  std::vector<Sample> offences;
  for (std::size_t i = 0; i < kOffences; ++i)
    offences.push_back({to_string(static_cast<Offence>(i)), real(refused[i])});
  page.add("strangers_refused_total", "What was refused at the worker, champion and HTTP ports, by offence.",
           MetricType::Counter, "offence", offences);
  add_process(page);
  return page.text();
}

}  // namespace evograsp::server

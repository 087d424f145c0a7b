#include "server/store.h"

#include <algorithm>
#include <chrono>
#include <future>
#include <map>
#include <optional>
#include <thread>
#include <utility>
#include <variant>

#include "common/digest.h"
#include "common/mutex.h"
#include "common/thread_name.h"
#include "server/store_open.h"
#include "server/store_tables.h"
#include "server/store_writer.h"

namespace evograsp::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kBatchRows = 4096;  // evaluations that are written without waiting longer
constexpr std::uint64_t kMostQueuedBytes = 256ull << 20;  // beyond this, big things wait for the disk
constexpr std::size_t kRowOverhead = 64;                  // what a queued row weighs besides its blob
// What strangers can cause a million of does not wait in a queue without end.
constexpr std::size_t kMostEvents = 10000;   // queued; no more are kept anyway
constexpr std::size_t kMostWorkers = 10000;  // the same

// Generations that follow each other faster share a transaction.
constexpr auto kMostPatience = std::chrono::milliseconds(100);

// A change other than an evaluation. What is queued together is one transaction; a durable change makes it
// one with full sync.
struct Change {
  std::function<Status(StoreTables&)> write;
  bool durable = false;
  std::optional<std::uint32_t> generation = {};  // that it commits
  Store::Callback done = {};
};
using Item = std::variant<Evaluation, Change>;

class StoreThread final : public Store {
 public:
  StoreThread(std::unique_ptr<StoreWriter> writer, const proto::StoreConfig& config, std::uint64_t epoch)
      : retention_(Retention::from(config)),
        period_(std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(std::min(config.journal_seconds(), 3600.0)))),
        patience_(std::min<Clock::duration>(period_, kMostPatience)),
        epoch_(epoch),
        writer_(std::move(writer)),
        thread_([this] { loop(); }) {}

  ~StoreThread() override {
    {
      const MutexLock lock(mutex_);
      closing_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }

  void journal(Evaluation evaluation) override {
    const std::size_t weight = evaluation.measurements.size() + kRowOverhead;
    MutexLock lock(mutex_);
    wait_for_space(lock);
    if (!status_) return;
    queue_.emplace_back(std::move(evaluation));
    queued_bytes_ += weight;
    // The first row starts the thread's clock; a full batch need not wait for it.
    const bool notify = queue_.size() == 1 || queue_.size() == kBatchRows;
    lock.unlock();
    if (notify) wake_.notify_one();
  }

  void commit_generation(GenerationCommit commit, Callback done) override {
    const std::size_t weight =
        commit.population.size() + commit.best.network.size() + commit.best.genotype.size();
    auto shared = std::make_shared<GenerationCommit>(std::move(commit));
    Change change;
    change.write = [this, shared](StoreTables& t) {
      return t.put_generation(*shared, unix_time(), retention_, newest_);
    };
    change.durable = true;
    change.generation = shared->record.generation;
    change.done = std::move(done);
    push(std::move(change), weight);
  }

  void hurry() override {
    {
      const MutexLock lock(mutex_);
      urgent_ = true;
    }
    wake_.notify_one();
  }

  void note(Event event) override {
    {
      const MutexLock lock(mutex_);
      if (queued_events_ >= kMostEvents) return;
      ++queued_events_;
    }
    push({[this, event = std::move(event)](StoreTables& t) {
      return t.put_event(event, unix_time(), retention_);
    }});
  }
  // Of each only the last word is written.
  void saw_worker(WorkerRecord worker) override {
    {
      const MutexLock lock(mutex_);
      if (workers_.size() >= kMostWorkers && !workers_.contains(worker.identity)) return;
      std::string identity = worker.identity;
      workers_.insert_or_assign(std::move(identity), std::move(worker));
      if (workers_.size() > 1) return;
    }
    wake_.notify_one();
  }
  void keep_poison(PoisonRecord poison) override {
    const std::size_t weight = poison.network.size() + poison.trials.size() + poison.reason.size();
    push({[poison = std::move(poison)](StoreTables& t) { return t.put_poison(poison); }}, weight);
  }
  void keep_validation(ValidationRecord validation) override {
    push({[validation](StoreTables& t) { return t.put_validation(validation); }});
  }
  void keep_champion(const proto::Champion& champion, Callback done) override {
    push({[bytes = deterministic_bytes(champion)](StoreTables& t) { return t.put_champion(bytes); },
          true,
          {},
          std::move(done)});
  }
  void set_state(std::string state, Callback done) override {
    push({[this, state = std::move(state)](StoreTables& t) {
            return t.put_progress({epoch_, state, unix_time()});
          },
          true,
          {},
          std::move(done)});
  }
  void forget_evaluations(std::uint32_t generation, std::string stage,
                          std::vector<std::uint64_t> genomes) override {
    push({[generation, stage = std::move(stage), genomes = std::move(genomes)](StoreTables& t) {
      return t.forget_evaluations(generation, stage, genomes);
    }});
  }
  void keep_race(std::uint32_t generation, std::uint32_t rounds) override {
    push({[generation, rounds](StoreTables& t) { return t.put_race(generation, rounds); }});
  }

  Status flush() override {
    std::promise<Status> promise;
    auto written = promise.get_future();
    // Writing the journal's tail is not enough: only a synced transaction of its own proves the disk took it.
    push(
        {[](StoreTables& t) { return t.touch(); }, true, {}, [&](const Status& s) { promise.set_value(s); }});
    return written.get();
  }

  Status status() const override {
    const MutexLock lock(mutex_);
    return status_;
  }
  StoreFigures figures() const override {
    const MutexLock lock(mutex_);
    StoreFigures figures = figures_;
    figures.queued_bytes = queued_bytes_;
    return figures;
  }

 private:
  // What weighs nothing never waits: callbacks may queue small changes from the store's own thread.
  void push(Change change, std::size_t weight = 0) {
    {
      MutexLock lock(mutex_);
      if (weight > 0) wait_for_space(lock);
      commits_waiting_ = commits_waiting_ || change.generation;
      durable_ = durable_ || change.durable;
      queued_bytes_ += weight + kRowOverhead;
      urgent_ = urgent_ || (change.durable && !change.generation) || queued_bytes_ > kMostQueuedBytes / 4;
      queue_.emplace_back(std::move(change));
    }
    wake_.notify_one();
  }

  void wait_for_space(MutexLock& lock) REQUIRES(mutex_) {
    while (queued_bytes_ >= kMostQueuedBytes && status_) lock.wait(space_);
  }
  bool due() const REQUIRES(mutex_) { return closing_ || urgent_ || queue_.size() >= kBatchRows; }

  // Waits until there is a batch worth writing; false when the store closes and nothing is left. full: the
  // batch holds something durable.
  bool take(std::vector<Item>& batch, bool& full) {
    MutexLock lock(mutex_);
    while (!closing_ && queue_.empty() && workers_.empty()) lock.wait(wake_);
    const Clock::time_point until = Clock::now() + period_;
    while (!due() && !commits_waiting_)
      if (!lock.wait_until(wake_, until)) break;
    if (commits_waiting_) {
      const Clock::time_point end = std::min(until, last_commit_ + patience_);
      while (!due())
        if (!lock.wait_until(wake_, end)) break;
    }
    batch.swap(queue_);
    if (!workers_.empty()) batch.emplace_back(take_workers());
    queued_events_ = 0;
    full = durable_;
    if (commits_waiting_) last_commit_ = Clock::now();
    durable_ = urgent_ = commits_waiting_ = false;
    queued_bytes_ = 0;
    lock.unlock();
    space_.notify_all();
    return !batch.empty();
  }

  Change take_workers() REQUIRES(mutex_) {
    std::vector<WorkerRecord> rows;
    rows.reserve(workers_.size());
    for (auto& [identity, worker] : workers_) rows.push_back(std::move(worker));
    workers_.clear();
    return {[this, rows = std::move(rows)](StoreTables& t) { return t.put_workers(rows, retention_); }};
  }

  void loop() {
    name_thread("store");
    std::vector<Item> batch;
    bool full = false;
    while (take(batch, full)) {
      write(batch, full);
      publish_figures();
      batch.clear();
    }
    if (status()) writer_->fold();
    writer_.reset();
  }

  // One transaction; then whoever asked is told.
  void write(std::vector<Item>& batch, bool full) {
    const Clock::time_point start = Clock::now();
    newest_.reset();
    std::uint64_t generations = 0;
    for (const Item& item : batch) {
      const Change* change = std::get_if<Change>(&item);
      if (change == nullptr || !change->generation) continue;
      newest_ = change->generation;
      ++generations;
    }
    if (!failed_) settle(writer_->sync(full));
    for (const Item& item : batch)
      if (!failed_) settle(put(item));
    if (!failed_) settle(writer_->end());
    if (generations > 0 && !failed_)
      count_commits(generations, std::chrono::duration<double>(Clock::now() - start).count());
    for (const Item& item : batch)
      if (const Change* change = std::get_if<Change>(&item); change != nullptr && change->done)
        change->done(status());
  }

  Status put(const Item& item) {
    const Evaluation* evaluation = std::get_if<Evaluation>(&item);
    if (evaluation == nullptr) return writer_->put(std::get<Change>(item).write);
    ++evaluations_;
    const bool pruned = newest_ && evaluation->generation < *newest_ && !retention_.all_evaluations;
    return pruned ? Status() : writer_->put(*evaluation);
  }

  // After the first error nothing more is written but that, if the disk takes it: whoever reads the file
  // shall not take the run for one that goes on.
  void settle(const Status& result) {
    if (result) return;
    writer_->roll_back();
    writer_->last_word({epoch_, "failed", unix_time()}, result.error().message, retention_);
    const MutexLock lock(mutex_);
    if (status_) status_ = result;
    failed_ = true;
    space_.notify_all();
  }

  void count_commits(std::uint64_t generations, double seconds) {
    const MutexLock lock(mutex_);
    figures_.commits += generations;
    figures_.last_commit_seconds = seconds;
    figures_.total_commit_seconds += seconds;
  }

  void publish_figures() {
    const std::uint64_t bytes = writer_->file_bytes();
    const MutexLock lock(mutex_);
    figures_.evaluations = evaluations_;
    figures_.transactions = writer_->transactions();
    figures_.file_bytes = bytes;
  }

  const Retention retention_;
  const Clock::duration period_, patience_;
  const std::uint64_t epoch_;

  mutable Mutex mutex_;
  std::condition_variable wake_, space_;
  std::vector<Item> queue_ GUARDED_BY(mutex_);
  std::uint64_t queued_bytes_ GUARDED_BY(mutex_) = 0;               // of queue_
  std::size_t queued_events_ GUARDED_BY(mutex_) = 0;                // in queue_
  std::map<std::string, WorkerRecord> workers_ GUARDED_BY(mutex_);  // to be written, by identity
  bool durable_ GUARDED_BY(mutex_) = false;                         // something in queue_ wants full sync
  bool urgent_ GUARDED_BY(mutex_) = false;                          // and somebody waits for it
  bool commits_waiting_ GUARDED_BY(mutex_) = false;                 // a generation is in queue_
  Clock::time_point last_commit_ GUARDED_BY(mutex_){};
  bool closing_ GUARDED_BY(mutex_) = false;
  Status status_ GUARDED_BY(mutex_);
  StoreFigures figures_ GUARDED_BY(mutex_);

  std::unique_ptr<StoreWriter> writer_;  // the store's thread's alone, with what follows
  bool failed_ = false;
  std::optional<std::uint32_t> newest_;  // generation that the batch being written commits last
  std::uint64_t evaluations_ = 0;

  std::thread thread_;  // last: starts when all else is there
};

Result<std::unique_ptr<Store>> start(OpenRun run, const proto::StoreConfig& config, std::uint64_t epoch) {
  auto tables = StoreTables::prepare(*run.database);
  if (!tables) return tl::unexpected<Error>(tables.error());
  auto writer = std::make_unique<StoreWriter>(std::move(run), std::move(*tables));
  return std::unique_ptr<Store>(new StoreThread(std::move(writer), config, epoch));
}

}  // namespace

bool Store::holds_run(const std::filesystem::path& run_dir) {
  return server::holds_run(run_dir);
}

Result<std::unique_ptr<Store>> Store::create(const std::filesystem::path& run_dir, NewRun run) {
  auto opened = open_new(run_dir, run);
  if (!opened) return tl::unexpected<Error>(opened.error());
  return start(std::move(*opened), run.info.config.store(), 1);
}

Result<Store::Resumed> Store::resume(const std::filesystem::path& run_dir) {
  Resumed resumed;
  auto opened = open_existing(run_dir, resumed.point);
  if (!opened) return tl::unexpected<Error>(opened.error());
  auto store = start(std::move(*opened), resumed.point.info.config.store(), resumed.point.epoch);
  if (!store) return tl::unexpected<Error>(store.error());
  resumed.store = std::move(*store);
  return resumed;
}

}  // namespace evograsp::server

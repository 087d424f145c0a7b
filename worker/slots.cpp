#include "worker/slots.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

#include "common/thread_name.h"

namespace evograsp::worker {

namespace {

// How long a suspect waits after its start has been announced, so that the news is out before it can do harm.
constexpr auto kAnnouncement = std::chrono::milliseconds(50);

std::uint64_t thread_nanoseconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<std::uint64_t>(t.tv_sec) * 1000000000U + static_cast<std::uint64_t>(t.tv_nsec);
}

zmq::message_t result_frame(const Job& job, Evaluator& evaluator) {
  const auto start = std::chrono::steady_clock::now();
  const std::uint64_t cpu = thread_nanoseconds();
  const proto::Task& task = job.envelope.task();
  google::protobuf::Arena arena;
  auto& envelope = *google::protobuf::Arena::CreateMessage<proto::Envelope>(&arena);
  envelope = make_envelope(job.stamp);
  proto::TaskResult& result = *envelope.mutable_result();
  result.set_id(task.id());
  result.set_attempt(task.attempt());
  evaluator.evaluate(task, job.networks, result);
  const auto wall = std::chrono::steady_clock::now() - start;
  result.set_wall_nanoseconds(
      static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(wall).count()));
  result.set_cpu_nanoseconds(thread_nanoseconds() - cpu);
  return to_frame(envelope);
}

zmq::message_t step_frame(const Job& job, Evaluator& evaluator) {
  proto::Envelope envelope = make_envelope(job.stamp);
  evaluator.step(job.envelope.step_request(), *envelope.mutable_step_reply());
  return to_frame(envelope);
}

}  // namespace

SlotPool::SlotPool(int slots, std::shared_ptr<Wakeup> wakeup)
    : wakeup_(std::move(wakeup)), running_(static_cast<std::size_t>(slots)) {
  try {
    for (std::size_t i = 0; i < running_.size(); ++i) threads_.emplace_back([this, i] { work(i); });
  } catch (const std::system_error& error) {
    end(0);
    for (std::thread& thread : threads_) thread.join();
    throw std::system_error(error.code(), "only " + std::to_string(threads_.size()) + " of " +
                                              std::to_string(slots) +
                                              " slots: give fewer --slots, or allow more threads (ulimit "
                                              "-u, pids.max of the container)");
  }
}

SlotPool::~SlotPool() {
  end(0);
  for (std::thread& thread : threads_) thread.join();
}

bool SlotPool::end(double seconds) {
  const auto until =
      std::chrono::steady_clock::now() +
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
  MutexLock lock(mutex_);
  stopping_ = true;
  queue_.clear();
  wanted_.notify_all();
  while (busy_ > 0)
    if (!lock.wait_until(idle_, until)) break;
  return busy_ == 0;
}

void SlotPool::set_simulator(std::shared_ptr<SharedSimulator> shared) {
  const MutexLock lock(mutex_);
  shared_ = std::move(shared);
  ++shared_version_;
}

void SlotPool::push(Job job) {
  {
    const MutexLock lock(mutex_);
    queue_.push_back(std::move(job));
  }
  wanted_.notify_one();
}

int SlotPool::cancel(std::span<const std::uint64_t> tasks) {
  const MutexLock lock(mutex_);
  return static_cast<int>(std::erase_if(queue_, [&](const Job& job) {
    return job.envelope.has_task() &&
           std::find(tasks.begin(), tasks.end(), job.envelope.task().id()) != tasks.end();
  }));
}

std::vector<std::uint64_t> SlotPool::take_back() {
  const MutexLock lock(mutex_);
  std::vector<std::uint64_t> tasks;
  for (const Job& job : queue_)
    if (job.envelope.has_task()) tasks.push_back(job.envelope.task().id());
  std::erase_if(queue_, [](const Job& job) { return !job.errand; });
  return tasks;
}

std::vector<SlotEvent> SlotPool::take_events() {
  const MutexLock lock(mutex_);
  return std::exchange(events_, {});
}

std::vector<StartedTask> SlotPool::take_started(std::chrono::milliseconds age) {
  const auto latest = std::chrono::steady_clock::now() - age;
  std::vector<StartedTask> started;
  const MutexLock lock(mutex_);
  for (std::optional<Running>& running : running_) {
    if (!running || running->taken || (!running->suspect && running->since > latest)) continue;
    running->taken = true;
    started.push_back(running->what);
  }
  return started;
}

int SlotPool::busy() const {
  const MutexLock lock(mutex_);
  return busy_;
}

int SlotPool::queued() const {
  const MutexLock lock(mutex_);
  return static_cast<int>(queue_.size());
}

void SlotPool::post(SlotEvent event) {
  bool first;
  {
    const MutexLock lock(mutex_);
    first = events_.empty();
    events_.push_back(std::move(event));
  }
  if (first) wakeup_->notify();
}

void SlotPool::work(std::size_t slot) {
  name_thread("slot");
  std::unique_ptr<Evaluator> evaluator;
  std::uint64_t version = ~std::uint64_t{0};
  MutexLock lock(mutex_);
  for (;;) {
    while (!stopping_ && queue_.empty()) lock.wait(wanted_);
    if (stopping_) return;
    Job job = std::move(queue_.front());
    queue_.pop_front();
    ++busy_;
    if (!job.errand && job.envelope.has_task()) {
      const proto::Task& task = job.envelope.task();
      running_[slot] = {
          {job.session, task.id(), task.attempt()}, std::chrono::steady_clock::now(), task.suspect(), false};
    }
    const std::uint64_t wanted_version = shared_version_;
    std::shared_ptr<SharedSimulator> shared = shared_;
    lock.unlock();
    try {
      if (version != wanted_version && !job.errand) {
        evaluator = std::make_unique<Evaluator>(std::move(shared));
        version = wanted_version;
      }
      if (job.errand)
        job.errand();
      else
        run(job, *evaluator);
    } catch (const std::exception& error) {
      fail_job(job, error.what());
    }
    lock.lock();
    --busy_;
    running_[slot].reset();
    if (stopping_) idle_.notify_all();
  }
}

void SlotPool::run(Job& job, Evaluator& evaluator) {
  if (job.envelope.has_step_request()) return post({job.session, 0, step_frame(job, evaluator)});
  if (job.envelope.task().suspect()) {
    wakeup_->notify();
    std::this_thread::sleep_for(kAnnouncement);
  }
  post({job.session, job.envelope.task().id(), result_frame(job, evaluator)});
}

// Out of memory, mostly: the answer is small.
void SlotPool::fail_job(const Job& job, const char* why) {
  if (job.errand) return;
  proto::Envelope envelope = make_envelope(job.stamp);
  if (job.envelope.has_step_request()) {
    envelope.mutable_step_reply()->set_id(job.envelope.step_request().id());
    envelope.mutable_step_reply()->set_client(job.envelope.step_request().client());
    envelope.mutable_step_reply()->set_error(why);
    return post({job.session, 0, to_frame(envelope)});
  }
  envelope.mutable_result()->set_id(job.envelope.task().id());
  envelope.mutable_result()->set_attempt(job.envelope.task().attempt());
  envelope.mutable_result()->set_error(why);
  post({job.session, job.envelope.task().id(), to_frame(envelope)});
}

}  // namespace evograsp::worker

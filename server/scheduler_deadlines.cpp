// What takes too long: slots that hang, and workers that hold tasks and do nothing.
#include <algorithm>

#include "server/scheduler.h"

namespace evograsp::server {

namespace {

constexpr double kStartGrace = 1;  // s: on its way, a task is nobody's fault

}  // namespace

void Scheduler::started(WorkerId worker, std::uint64_t number, std::uint32_t attempt, double now) {
  const auto task = tasks_.find(number);
  if (task == tasks_.end()) return;
  for (Attempt& a : task->second.attempts) {
    if (a.worker != worker || a.number != attempt || a.started >= 0) continue;
    a.started = now;
    workers_.at(worker).moved = now;
  }
}

void Scheduler::came_back(WorkerId id, std::uint64_t number, std::uint32_t attempt, double now) {
  Worker& worker = workers_.at(id);
  const auto freed = std::erase_if(
      worker.forgotten, [&](const Forgotten& f) { return f.task == number && f.number == attempt; });
  if (freed > 0 || find(id, number, attempt)) worker.moved = now;
}

// Nobody waits for it any more, but while it runs its slot is taken.
void Scheduler::forget(const Task& task, const Attempt& attempt) {
  if (attempt.started < 0) return;
  workers_.at(attempt.worker).forgotten.push_back({task.what.task, attempt.number, attempt.started});
  no_hung_before_ = std::min(no_hung_before_, attempt.started + options_.task_deadline);
}

void Scheduler::excuse(double seconds, double now) {
  const auto later = [&](double& time) { time = std::min(now, time + seconds); };
  for (auto& [number, task] : tasks_)
    for (Attempt& attempt : task.attempts) {
      later(attempt.sent);
      if (attempt.started >= 0) later(attempt.started);
    }
  for (auto& [id, worker] : workers_) {
    later(worker.moved);
    for (Forgotten& forgotten : worker.forgotten) later(forgotten.started);
  }
}

std::vector<Scheduler::Hung> Scheduler::expire(double now) {
  std::vector<Hung> hung;
  if (now <= no_hung_before_) return hung;
  no_hung_before_ = now + options_.task_deadline;
  const auto hangs = [&](double started) {
    if (started < 0) return false;
    if (now - started > options_.task_deadline) return true;
    no_hung_before_ = std::min(no_hung_before_, started + options_.task_deadline);
    return false;
  };
  const auto lose_slot = [&](WorkerId id, Worker& worker) {
    ++counts_.expired;
    if (worker.slots == 0) return;
    --worker.slots;
    --total_slots_;
    count(id, worker);
  };
  for (const auto& [number, task] : tasks_)
    for (const Attempt& attempt : task.attempts)
      if (hangs(attempt.started)) hung.push_back({attempt.worker, number});
  for (const Hung& h : hung) {
    Worker& worker = workers_.at(h.worker);
    lose_slot(h.worker, worker);
    add_try(tasks_.at(h.task).what, worker.party, true);
    end_attempt(h.worker, worker, h.task);
  }
  for (auto& [id, worker] : workers_) {
    for (const Forgotten& forgotten : worker.forgotten) {
      if (now - forgotten.started <= options_.task_deadline) continue;
      hung.push_back({id, forgotten.task});
      lose_slot(id, worker);
    }
    std::erase_if(worker.forgotten, [&](const Forgotten& f) { return hangs(f.started); });
  }
  return hung;
}

std::vector<WorkerId> Scheduler::idle(double now) {
  std::vector<WorkerId> idle;
  if (now <= no_idle_before_) return idle;
  const double patience = options_.task_deadline + kStartGrace;
  no_idle_before_ = now + patience;
  for (const auto& [id, worker] : workers_) {
    for (const std::uint64_t number : worker.tasks) {  // in the order sent: the first has waited longest
      const std::vector<Attempt>& attempts = tasks_.at(number).attempts;
      const auto own = std::find_if(attempts.begin(), attempts.end(),
                                    [id = id](const Attempt& a) { return a.worker == id; });
      if (own->started >= 0) continue;
      const double since = std::max(own->sent, worker.moved);
      if (now - since > patience) {
        idle.push_back(id);
        idle_.insert(worker.party);
        count(id, worker);
      } else {
        no_idle_before_ = std::min(no_idle_before_, since + patience);
      }
      break;
    }
  }
  return idle;
}

}  // namespace evograsp::server

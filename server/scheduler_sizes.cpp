// How much a worker is given at a time, of which network, and which tasks are done twice because they are
// late.
#include <algorithm>
#include <cmath>
#include <utility>

#include "server/scheduler.h"

namespace evograsp::server {

namespace {

constexpr std::uint32_t kShare = 2;               // tasks a slot that the remaining work is cut into
constexpr std::size_t kMaxTaskBytes = 256 << 10;  // of networks in one message: heartbeats queue behind it
constexpr std::size_t kMaxTaskNetworks = 256;
constexpr double kMaxTaskTrials = 16384;  // their result stays within half of kMaxEnvelopeToMaster
constexpr std::uint32_t kMaxCredit = 64;
constexpr std::size_t kMaxWorkerBytes = 4 << 20;  // of networks in flight beyond the least credit
constexpr std::uint32_t kMaxCopies = 2;           // of one task at a time
constexpr double kStragglerFactor = 3;            // times its expected duration, before a task is copied
constexpr double kStragglerGrace = 0.02;          // s
constexpr double kSlower = 1.5;                   // times the mean: a slow worker

}  // namespace

double Scheduler::cost(const Worker& worker) const {
  if (worker.trial_seconds[kind_] > 0) return worker.trial_seconds[kind_];
  return worker.estimate > 0 && kind_ == 0 ? worker.estimate : trial_seconds_[kind_];
}

std::uint32_t Scheduler::credit(const Worker& worker) const {
  const double task =
      std::max(kSmallestTask, std::min(options_.task_seconds, task_trials(worker) * cost(worker)));
  const std::deque<double>& trips = worker.round_trips;
  const double round_trip = trips.empty() ? 0 : *std::min_element(trips.begin(), trips.end());
  const double wanted = 1 + std::ceil(round_trip / task);
  const double slot =
      std::clamp(wanted, static_cast<double>(options_.credit), static_cast<double>(kMaxCredit));
  return worker.slots * static_cast<std::uint32_t>(slot);
}

// More than the least credit only while it is cheap: megabytes that wait for a starved worker are megabytes
// that nobody else can take.
bool Scheduler::full(const Worker& worker) const {
  if (worker.tasks.size() + worker.forgotten.size() >= credit(worker)) return true;
  const std::size_t least = static_cast<std::size_t>(worker.slots) * std::max(1U, options_.credit);
  return worker.tasks.size() >= least && worker.bytes >= kMaxWorkerBytes;
}

std::uint32_t Scheduler::task_trials(const Worker& worker) const {
  const double each = cost(worker);
  // Of a generation that is still being handed out, only what is here can be spread.
  const auto here = static_cast<double>(
      std::min<std::uint64_t>(trials_pending_, (queue_.size() + rests_.size()) * std::uint64_t{trials_}));
  const double guided = here / (std::max(1U, total_slots_) * kShare);
  const double most = options_.task_seconds / each;
  const double least = kSmallestTask / each;
  return static_cast<std::uint32_t>(std::clamp(std::max(least, std::min(guided, most)), 1.0, kMaxTaskTrials));
}

// From what the worker has begun, or from the front of the queue: whole networks of the same trials while
// they fit, or a part of a large one, whose rest waits for this worker. When nothing else is left, from the
// end of the largest rest of another.
Assignment Scheduler::cut(WorkerId id, const Worker& worker) {
  const std::uint32_t target = task_trials(worker);
  Assignment what;
  what.task = next_task_++;
  auto rest = rests_.find(id);
  if (rest == rests_.end() && !queue_.empty()) {
    if (take_whole(what, target)) return what;
    rest = rests_.emplace(id, queue_.front()).first;
    queue_.pop_front();
  }
  const bool own = rest != rests_.end();
  if (!own) rest = largest_rest();
  Unit& unit = rest->second;
  what.networks.push_back(unit.network);
  what.trials = std::min(unit.count, target);
  // A remainder of less than half a task would cost more than it spreads.
  if (unit.count - what.trials < (what.trials + 1) / 2) what.trials = unit.count;
  what.first_trial = own ? unit.first : unit.first + unit.count - what.trials;
  if (own) unit.first += what.trials;
  unit.count -= what.trials;
  trials_pending_ -= what.trials;
  if (unit.count == 0) rests_.erase(rest);
  return what;
}

// False when the first unit of the queue is more than a task.
bool Scheduler::take_whole(Assignment& what, std::uint32_t target) {
  const Unit& front = queue_.front();
  const std::uint32_t part = std::min(front.count, target);
  if (front.count - part >= (part + 1) / 2) return false;
  what.first_trial = front.first;
  what.trials = front.count;
  std::size_t bytes = 0;
  while (!queue_.empty() && what.networks.size() < kMaxTaskNetworks) {
    const Unit unit = queue_.front();
    bytes += bytes_[unit.network];
    const bool first = what.networks.empty();
    const bool fits = bytes <= kMaxTaskBytes && (what.networks.size() + 1) * what.trials <= target;
    const bool same = unit.first == what.first_trial && unit.count == what.trials;
    if (!first && !(same && fits)) break;
    what.networks.push_back(unit.network);
    trials_pending_ -= unit.count;
    queue_.pop_front();
  }
  return true;
}

std::map<WorkerId, Scheduler::Unit>::iterator Scheduler::largest_rest() {
  return std::max_element(rests_.begin(), rests_.end(),
                          [](const auto& a, const auto& b) { return a.second.count < b.second.count; });
}

void Scheduler::give_up_rest(WorkerId worker) {
  const auto rest = rests_.find(worker);
  if (rest == rests_.end()) return;
  queue_.push_front(rest->second);
  rests_.erase(rest);
}

// When the task should be back at its holder's pace, and when it is overdue at anybody's.
Scheduler::Times Scheduler::times(const Task& task) const {
  const Attempt& attempt = task.attempts.front();
  const Worker& holder = workers_.at(attempt.worker);
  const double trials = task.what.trials * static_cast<double>(task.what.networks.size());
  const double round_trip = holder.round_trips.empty() ? 0 : holder.round_trips.back();  // queues included
  const double since = attempt.started >= 0 ? attempt.started : attempt.sent;
  return {since + cost(holder) * trials,
          since + kStragglerFactor * trial_seconds_[kind_] * trials + round_trip + kStragglerGrace};
}

// Of the tasks that are overdue, or that this worker would have done well before their slower holder, the one
// that has been out longest; with a copy to spare, and none of it on this worker.
Scheduler::Task* Scheduler::straggler(WorkerId id, double now) {
  if (now < no_straggler_before_) return nullptr;
  no_straggler_before_ = now + kStragglerGrace;
  const Worker& worker = workers_.at(id);
  Task* oldest = nullptr;
  for (auto& [number, task] : tasks_) {
    if (task.attempts.size() >= kMaxCopies || task.what.suspect) continue;
    const Attempt& attempt = task.attempts.front();
    const Times when = times(task);
    const bool slow = cost(workers_.at(attempt.worker)) > kSlower * trial_seconds_[kind_];
    no_straggler_before_ = std::min(no_straggler_before_, slow ? now : when.overdue);
    const double mine = cost(worker) * task.what.trials * static_cast<double>(task.what.networks.size());
    const bool sooner = slow && now + mine + kStragglerGrace < when.back;
    if (!sooner && now < when.overdue) continue;
    if (attempt.worker == id || !may(worker, task.what.audit)) continue;
    const bool older = oldest == nullptr || attempt.sent < oldest->attempts.front().sent ||
                       (attempt.sent == oldest->attempts.front().sent && number < oldest->what.task);
    if (older) oldest = &task;
  }
  return oldest;
}

}  // namespace evograsp::server

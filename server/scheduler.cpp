#include "server/scheduler.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace evograsp::server {

namespace {

constexpr double kFirstGuess = 1e-4;                     // s a trial, before any has been measured
constexpr double kLeastTrial = 1e-7, kMostTrial = 3600;  // s a trial that is believed
constexpr double kLiftGuess = 0.08;                      // s, the same of a lift test
constexpr std::size_t kRoundTrips = 16;  // heartbeats that the shortest round trip is taken of
constexpr double kLearningRate = 0.2;

}  // namespace

Scheduler::Scheduler(const SchedulerOptions& options)
    : options_(options), trial_seconds_{kFirstGuess, kLiftGuess} {}

void Scheduler::join(WorkerId worker, std::uint32_t slots, Party party) {
  workers_[worker].slots = slots;
  workers_[worker].party = party;
  total_slots_ += slots;
  many_hosts_ = many_hosts_ || party.host != first_host_.value_or(party.host);
  first_host_ = first_host_.value_or(party.host);
  count(worker, workers_[worker]);
}

void Scheduler::set_active(WorkerId worker, bool active) {
  workers_.at(worker).active = active;
  count(worker, workers_.at(worker));
  if (!active) give_up_rest(worker);
}

void Scheduler::leave(WorkerId id, Departure departure) {
  const auto found = workers_.find(id);
  if (found == workers_.end()) return;
  Worker worker = std::move(found->second);
  workers_.erase(found);
  worker.active = false;
  count(id, worker);
  total_slots_ -= worker.slots;
  give_up_rest(id);
  // Backwards, because requeue() puts work at the front: the oldest task shall be the first again.
  const std::vector<std::uint64_t> held = worker.tasks;
  for (auto task = held.rbegin(); task != held.rend(); ++task) {
    const Task& lost = tasks_.at(*task);
    const auto attempt = std::find_if(lost.attempts.begin(), lost.attempts.end(),
                                      [&](const Attempt& a) { return a.worker == id; });
    blame(lost.what, *attempt, worker, departure);
    end_attempt(id, worker, *task);
  }
}

void Scheduler::set_round_trip(WorkerId worker, double seconds) {
  std::deque<double>& last = workers_.at(worker).round_trips;
  last.push_back(seconds);
  if (last.size() > kRoundTrips) last.pop_front();
}

void Scheduler::set_estimate(WorkerId worker, double trial_seconds) {
  if (trial_seconds >= kLeastTrial && trial_seconds <= kMostTrial)
    workers_.at(worker).estimate = trial_seconds;
}

void Scheduler::begin(std::uint32_t networks, std::uint32_t trials, bool lifts) {
  abandon();
  kind_ = lifts ? 1 : 0;
  trials_ = trials;
  networks_left_ = networks;
  trials_pending_ = static_cast<std::uint64_t>(networks) * trials;
  left_.assign(networks, trials);
  records_.assign(networks, {});
  bytes_.assign(networks, 0);
}

void Scheduler::add(std::uint32_t index, std::size_t bytes) {
  bytes_[index] = static_cast<std::uint32_t>(std::min<std::size_t>(bytes, UINT32_MAX));
  queue_.push_back({index, 0, trials_});
}

void Scheduler::abandon() {
  for (const auto& [number, task] : tasks_)
    for (const Attempt& attempt : task.attempts) forget(task, attempt);
  for (auto& [id, worker] : workers_) {
    worker.tasks.clear();
    worker.bytes = 0;
    worker.exclusive = false;
  }
  tasks_.clear();
  queue_.clear();
  rests_.clear();
  suspects_.clear();
  audits_.clear();
  not_by_.clear();
  poisoned_.clear();
  networks_left_ = 0;
  trials_pending_ = 0;
  no_straggler_before_ = 0;
}

std::optional<Assignment> Scheduler::next(WorkerId id, double now) {
  Worker& worker = workers_.at(id);
  if (worker.exclusive || worker.slots == 0) return std::nullopt;
  if (!suspects_.empty() && worker.tasks.empty() && worker.forgotten.empty())
    if (auto suspect = next_suspect(id, worker, now)) return suspect;
  if (full(worker)) return std::nullopt;
  if (!audits_.empty())
    if (auto audit = next_audit(id, worker, now)) return audit;
  if (!queue_.empty() || !rests_.empty()) {
    Task task;
    task.what = cut(id, worker);
    return give(id, worker, tasks_.emplace(task.what.task, std::move(task)).first->second, now);
  }
  // Copies are for idle slots only: work that waits its turn elsewhere may still be in time.
  if (!options_.speculate || worker.tasks.size() + worker.forgotten.size() >= worker.slots)
    return std::nullopt;
  Task* slow = straggler(id, now);
  if (slow == nullptr) return std::nullopt;
  ++counts_.speculated;
  return give(id, worker, *slow, now);
}

Assignment Scheduler::give(WorkerId id, Worker& worker, Task& task, double now) {
  ++counts_.tasks;
  if (task.attempts.empty() && task.bytes == 0)
    for (const std::uint32_t network : task.what.networks) task.bytes += bytes_[network];
  worker.bytes += task.bytes;
  const std::uint32_t number = task.next_attempt++;
  task.attempts.push_back({id, number, now, -1});
  worker.tasks.push_back(task.what.task);
  Assignment given = task.what;
  given.attempt = number;
  return given;
}

void Scheduler::unsend(WorkerId worker, const Assignment& assignment) {
  end_attempt(worker, workers_.at(worker), assignment.task);
}

std::optional<Assignment> Scheduler::find(WorkerId worker, std::uint64_t number,
                                          std::uint32_t attempt) const {
  const auto task = tasks_.find(number);
  if (task == tasks_.end()) return std::nullopt;
  for (const Attempt& a : task->second.attempts)
    if (a.worker == worker && a.number == attempt) return task->second.what;
  return std::nullopt;
}

Scheduler::Accepted Scheduler::result(WorkerId id, std::uint64_t number, double seconds) {
  Accepted accepted;
  const auto found = tasks_.find(number);
  accepted.assignment = found->second.what;
  const Assignment& what = accepted.assignment;
  for (const Attempt& attempt : found->second.attempts) {
    Worker& holder = workers_.at(attempt.worker);
    std::erase(holder.tasks, number);
    holder.bytes -= found->second.bytes;
    if (what.suspect) holder.exclusive = false;
    if (attempt.worker == id) continue;
    accepted.cancel.push_back(attempt.worker);
    forget(found->second, attempt);
  }
  if (idle_.erase(workers_.at(id).party) > 0) count(id, workers_.at(id));
  learn(workers_.at(id), seconds, what.networks.size() * what.trials);
  tasks_.erase(found);
  for (const std::uint32_t network : what.networks) {
    if (left_[network] == 0) continue;  // poisoned meanwhile
    left_[network] -= what.trials;
    if (left_[network] > 0) continue;
    accepted.complete.push_back(network);
    --networks_left_;
  }
  return accepted;
}

void Scheduler::learn(Worker& worker, double seconds, std::size_t trials) {
  const double each = std::max(kLeastTrial, seconds / static_cast<double>(trials));
  double& own = worker.trial_seconds[kind_];
  own = own > 0 ? own + kLearningRate * (each - own) : each;
  trial_seconds_[kind_] += kLearningRate * (each - trial_seconds_[kind_]);
}

void Scheduler::failed(WorkerId worker, std::uint64_t number) {
  add_try(tasks_.at(number).what, workers_.at(worker).party, true);
  end_attempt(worker, workers_.at(worker), number);
}

void Scheduler::end_attempt(WorkerId id, Worker& worker, std::uint64_t number) {
  Task& task = tasks_.at(number);
  std::erase(worker.tasks, number);
  worker.bytes -= task.bytes;
  if (task.what.suspect) worker.exclusive = false;
  std::erase_if(task.attempts, [&](const Attempt& a) { return a.worker == id; });
  if (!task.attempts.empty()) return;
  const Assignment what = std::move(task.what);
  tasks_.erase(number);
  requeue(what);
}

// One unit a network, so that the innocent part from the guilty.
void Scheduler::requeue(const Assignment& what) {
  ++counts_.requeued;
  for (auto network = what.networks.rbegin(); network != what.networks.rend(); ++network) {
    if (left_[*network] == 0) continue;
    std::deque<Unit>& where = is_suspect(*network) ? suspects_ : what.audit != 0 ? audits_ : queue_;
    where.push_front({*network, what.first_trial, what.trials, what.audit});
    trials_pending_ += what.trials;
  }
}

std::uint32_t Scheduler::outstanding(WorkerId worker) const {
  return static_cast<std::uint32_t>(workers_.at(worker).tasks.size());
}

double Scheduler::trial_seconds(WorkerId worker) const {
  const Worker& w = workers_.at(worker);
  return w.trial_seconds[0] > 0 ? w.trial_seconds[0] : w.estimate;
}

std::uint32_t Scheduler::slots(WorkerId worker) const {
  return workers_.at(worker).slots;
}

}  // namespace evograsp::server

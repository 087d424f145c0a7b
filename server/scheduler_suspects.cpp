// Networks that may have killed or hung a worker: who tries them next, and when it is enough.
//
// What is counted are different workers, not deaths: one machine that dies of everything is to change nothing
// while there are others. So a suspect goes first to hosts where it has not been tried, then to workers that
// have not tried it, and to the rest only when nobody else is here. It is given up when K workers on two
// hosts died of it or hung; of one host K are enough when no other has ever been here. Whoever was lost, and
// however, after kPatience x K tries it is given up, too: a run that has one worker ends.
//
// Silence alone is no strike: the worker may have been frozen, or its link cut. It counts as a try.
#include <algorithm>
#include <set>
#include <utility>

#include "server/scheduler.h"

namespace evograsp::server {

namespace {

constexpr std::uint8_t kLossesToSuspect = 2;
constexpr std::uint64_t kPatience = 4;

// How new the network is to the worker: 2 to its host, 1 to itself, 0 to neither.
template <class Tries>
int novelty(const Party& party, const Tries& tries) {
  int most = 2;
  for (const auto& t : tries) {
    if (t.party == party) return 0;
    if (t.party.host == party.host) most = 1;
  }
  return most;
}

}  // namespace

// Runs alone on its worker, so that nothing else can be blamed.
std::optional<Assignment> Scheduler::next_suspect(WorkerId id, Worker& worker, double now) {
  const auto unit =
      std::find_if(suspects_.begin(), suspects_.end(), [&](const Unit& u) { return suits(worker, u); });
  if (unit == suspects_.end()) return std::nullopt;
  Task task;
  task.what = {next_task_++, 0, {unit->network}, unit->first, unit->count, true, unit->audit};
  trials_pending_ -= unit->count;
  suspects_.erase(unit);
  worker.exclusive = true;
  return give(id, worker, tasks_.emplace(task.what.task, task).first->second, now);
}

// No other that works, and that may, has had less to do with it. Who has left work lying comes last of all.
bool Scheduler::suits(const Worker& worker, const Unit& unit) const {
  if (!may(worker, unit.audit)) return false;
  const std::vector<Try>& tries = records_[unit.network].tries;
  const int own = idle_.contains(worker.party) ? -1 : novelty(worker.party, tries);
  if (own == 2) return true;
  return std::none_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
    const Worker& other = entry.second;
    return gives_opinions(other) && novelty(other.party, tries) > own && may(other, unit.audit);
  });
}

bool Scheduler::is_suspect(std::uint32_t network) const {
  const Record& record = records_[network];
  return !record.tries.empty() || record.losses >= kLossesToSuspect;
}

// Before a network is suspect, others run beside it: silence then says nothing about it.
void Scheduler::blame(const Assignment& what, const Attempt& attempt, const Worker& by, Departure departure) {
  if (departure == Departure::kLeft) return;
  const bool strike = departure == Departure::kDied;
  if (attempt.started >= 0 && (strike || what.suspect)) add_try(what, by.party, strike);
  for (const std::uint32_t network : what.networks) {
    std::uint8_t& losses = records_[network].losses;
    if (losses < kLossesToSuspect) ++losses;
  }
}

// Only what ran alone is given up: the first time, it may have been another's doing.
void Scheduler::add_try(const Assignment& what, Party party, bool strike) {
  for (const std::uint32_t network : what.networks) {
    if (left_[network] == 0) continue;
    if (strike) ++counts_.strikes;
    records_[network].tries.push_back({party, strike});
    if (what.suspect && is_enough(records_[network])) poison(network);
  }
}

bool Scheduler::is_enough(const Record& record) const {
  if (record.tries.size() >= kPatience * options_.poison_strikes) return true;
  std::set<Party> workers;
  std::set<std::uint64_t> hosts;
  for (const Try& t : record.tries) {
    if (!t.strike) continue;
    workers.insert(t.party);
    hosts.insert(t.party.host);
  }
  return workers.size() >= options_.poison_strikes && (hosts.size() >= 2 || !many_hosts_);
}

void Scheduler::poison(std::uint32_t network) {
  Record& record = records_[network];
  record.given_up = true;
  std::set<Party> workers;
  std::set<std::uint64_t> hosts;
  for (const Try& t : record.tries) {
    workers.insert(t.party);
    hosts.insert(t.party.host);
  }
  poisoned_.push_back({network, static_cast<std::uint32_t>(workers.size()),
                       static_cast<std::uint32_t>(hosts.size()),
                       static_cast<std::uint32_t>(record.tries.size())});
  left_[network] = 0;
  --networks_left_;
  const auto drop = [&](std::deque<Unit>& units) {
    for (const Unit& unit : units)
      if (unit.network == network) trials_pending_ -= unit.count;
    std::erase_if(units, [&](const Unit& unit) { return unit.network == network; });
  };
  drop(queue_);
  std::erase_if(rests_, [&](const auto& entry) {
    if (entry.second.network != network) return false;
    trials_pending_ -= entry.second.count;
    return true;
  });
  drop(suspects_);
  drop(audits_);
}

std::vector<Poisoned> Scheduler::take_poisoned() {
  return std::exchange(poisoned_, {});
}

}  // namespace evograsp::server

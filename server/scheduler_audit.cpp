// Work that is done once more, to compare.
#include <algorithm>
#include <utility>

#include "server/scheduler.h"

namespace evograsp::server {

// Books whether the worker takes work now.
void Scheduler::count(WorkerId id, const Worker& worker) {
  if (gives_opinions(worker)) {
    able_[worker.party.host][id] = worker.party.identity;
    return;
  }
  const auto host = able_.find(worker.party.host);
  if (host == able_.end()) return;
  host->second.erase(id);
  if (host->second.empty()) able_.erase(host);
}

// Somebody takes work, or will in a moment, who is none of them, on none of their hosts.
bool Scheduler::another_host(const std::vector<Party>& heard) const {
  const auto spoke = [&](std::uint64_t host) {
    return std::any_of(heard.begin(), heard.end(), [&](const Party& p) { return p.host == host; });
  };
  if (!std::all_of(awaited_.begin(), awaited_.end(), spoke)) return true;
  return std::any_of(able_.begin(), able_.end(), [&](const auto& host) {
    return !spoke(host.first) && std::any_of(host.second.begin(), host.second.end(), [&](const auto& worker) {
      return std::find(heard.begin(), heard.end(), Party(worker.second)) == heard.end();
    });
  });
}

bool Scheduler::may(const Worker& worker, const std::vector<Party>& not_by) const {
  bool same_host = false;
  for (const Party& party : not_by) {
    if (party == worker.party) return false;
    same_host = same_host || party.host == worker.party.host;
  }
  return !same_host || !another_host(not_by);
}

// Whether the worker's opinion on the audit counts.
bool Scheduler::may(const Worker& worker, std::uint32_t audit) const {
  if (audit == 0) return true;
  if (idle_.contains(worker.party)) return false;
  const auto found = not_by_.find(audit);
  return found == not_by_.end() || may(worker, found->second);
}

bool Scheduler::gives_opinions(const Worker& worker) const {
  return worker.active && worker.slots > 0 && !idle_.contains(worker.party);
}

int Scheduler::auditors() const {
  std::optional<Party> first;
  for (const auto& [id, worker] : workers_) {
    if (!gives_opinions(worker)) continue;
    if (first && *first != worker.party) return 2;
    first = worker.party;
  }
  return first ? 1 : 0;
}

bool Scheduler::can_audit(const std::vector<Party>& not_by) const {
  return std::any_of(able_.begin(), able_.end(), [&](const auto& host) {
    return std::any_of(host.second.begin(), host.second.end(), [&](const auto& worker) {
      return std::find(not_by.begin(), not_by.end(), Party(worker.second)) == not_by.end();
    });
  });
}

void Scheduler::audit(std::uint32_t audit, const Piece& piece, std::vector<Party> not_by) {
  left_[piece.network] += piece.trials;
  trials_pending_ += piece.trials;
  not_by_[audit] = std::move(not_by);
  (is_suspect(piece.network) ? suspects_ : audits_)
      .push_back({piece.network, piece.first, piece.trials, audit});
}

std::optional<Assignment> Scheduler::next_audit(WorkerId id, Worker& worker, double now) {
  const auto unit =
      std::find_if(audits_.begin(), audits_.end(), [&](const Unit& u) { return may(worker, u.audit); });
  if (unit == audits_.end()) return std::nullopt;
  Task task;
  task.what = {next_task_++, 0, {unit->network}, unit->first, unit->count, false, unit->audit};
  trials_pending_ -= unit->count;
  audits_.erase(unit);
  return give(id, worker, tasks_.emplace(task.what.task, task).first->second, now);
}

void Scheduler::forget_audit(const Unit& unit, std::vector<std::uint32_t>& complete) {
  trials_pending_ -= unit.count;
  not_by_.erase(unit.audit);
  left_[unit.network] -= unit.count;
  if (left_[unit.network] > 0) return;
  --networks_left_;
  complete.push_back(unit.network);
}

void Scheduler::withdraw_audit(std::uint32_t audit) {
  for (std::deque<Unit>* units : {&audits_, &suspects_}) {
    const auto unit =
        std::find_if(units->begin(), units->end(), [&](const Unit& u) { return u.audit == audit; });
    if (unit == units->end() || left_[unit->network] <= unit->count) continue;
    const Unit withdrawn = *unit;
    units->erase(unit);
    std::vector<std::uint32_t> none;
    forget_audit(withdrawn, none);
    return;
  }
}

bool Scheduler::only_audits_left() const {
  const auto audit = [](const Unit& unit) { return unit.audit != 0; };
  return queue_.empty() && rests_.empty() && std::all_of(suspects_.begin(), suspects_.end(), audit) &&
         std::all_of(tasks_.begin(), tasks_.end(),
                     [](const auto& entry) { return entry.second.what.audit != 0; });
}

Scheduler::Skipped Scheduler::skip_audits(bool patient) {
  Skipped skipped;
  if ((audits_.empty() && suspects_.empty()) || !only_audits_left()) return skipped;
  for (std::deque<Unit>* units : {&audits_, &suspects_}) {
    for (auto unit = units->begin(); unit != units->end();) {
      const std::vector<Party>& not_by = not_by_[unit->audit];
      const bool disputed = not_by.size() > 1;
      const bool nobody = !can_audit(not_by);
      skipped.disputed = skipped.disputed || (disputed && nobody);
      if (disputed || !nobody || patient) {
        skipped.waiting = skipped.waiting || (nobody && !disputed);
        ++unit;
        continue;
      }
      skipped.audits.push_back(unit->audit);
      const Unit given_up = *unit;
      unit = units->erase(unit);
      forget_audit(given_up, skipped.complete);
    }
  }
  return skipped;
}

bool Scheduler::redo(const Piece& piece) {
  if (records_[piece.network].given_up) return false;
  if (left_[piece.network] == 0) ++networks_left_;
  left_[piece.network] += piece.trials;
  trials_pending_ += piece.trials;
  ++counts_.requeued;
  (is_suspect(piece.network) ? suspects_ : queue_).push_front({piece.network, piece.first, piece.trials});
  return true;
}

}  // namespace evograsp::server

// Sessions that end: whose connection is gone, who is silent, whose slots hang, who does nothing.
#include <algorithm>

#include "common/counted.h"
#include "server/dispatch_loop.h"
#include "server/store_records.h"

namespace evograsp::server {

namespace {

constexpr double kDeafFactor = 4;        // times the silence limit, while messages wait unread
constexpr double kTransportSeconds = 5;  // less than the transport's own patience
constexpr double kUnlistedSeconds = 60;  // between two lines about what is not listed
constexpr double kAbsentSeconds = 0.2;   // between two ticks: this thread did not run, and heard nobody

}  // namespace

// A worker that was asked to go and is killed before it is through was preempted: nothing it held is to
// blame.
void DispatchLoop::end_session(Session& session, Departure departure, const std::string& why) {
  if (session.view.state == "draining") departure = Departure::kLeft;
  const std::uint32_t held = scheduler_.outstanding(session.id);
  scheduler_.leave(session.id, departure);
  session.view.state = "gone";
  session.view.outstanding = 0;
  session.view.heard = unix_time();
  sink_.worker(session.view);
  const bool lost = departure != Departure::kLeft;
  if (!session.leaving && !session.held) note_parted(session);
  if (lost) ++totals_.lost;
  list(lost, lost ? "worker_lost" : "worker_left",
       "worker " + session.view.identity + ": " + why + "; " + counted(static_cast<long long>(held), "task") +
           (held == 1 ? " goes" : " go") + " to others");
  by_id_.erase(session.id);
  fail_steps_of(session.id);
  sessions_.erase(std::string(session.peer));  // the session dies here
  report_poisoned();
}

// The connection of one that had been silent for long ended of that: the transport gives up a peer that does
// not answer (common/socket.h). A process that dies was heard a moment ago.
Departure DispatchLoop::how_it_went(const Session& session) const {
  const double limit = std::min(options_.silence_seconds, kTransportSeconds);
  return now() - session.heard > limit ? Departure::kSilent : Departure::kDied;
}

// Who comes and goes, as long as a person could read it.
void DispatchLoop::list(bool warning, const std::string& kind, const std::string& text) {
  if (listed_.allow(now())) sink_.event(warning, kind, text);
}

void DispatchLoop::say_unlisted() {
  const std::uint64_t unlisted = listed_.held_back() - said_unlisted_;
  if (unlisted == 0 || now() < next_unlisted_) return;
  next_unlisted_ = now() + kUnlistedSeconds;
  said_unlisted_ = listed_.held_back();
  sink_.event(true, "unlisted",
              "workers come and go too fast to list: " + std::to_string(unlisted) + " more joined or went");
}

void DispatchLoop::drop_disconnected() {
  bool lost = false;
  const ConnectionMonitor::News news = monitor_.drain();
  for (const FailedHandshake& failed : news.failed)
    complain(Offence::kHandshake, "refused", failed.address,
             std::string("at the worker port: ") + to_string(failed.why));
  for (const int fd : news.closed) {
    const auto session =
        std::find_if(by_id_.begin(), by_id_.end(), [&](const auto& entry) { return entry.second->fd == fd; });
    if (session == by_id_.end()) continue;
    end_session(*session->second, how_it_went(*session->second), "its connection ended");
    lost = true;
  }
  if (!lost) return;
  pump_all();
  finish_if_done();
}

// Silence is what a peer does not say while somebody listens. When this thread itself did not run (no
// processor to be had, a stopped process, a machine asleep), that time is nobody's silence: what they said
// meanwhile waits in the socket. Nor is it time that a task took: the slots of this process stood still, too.
void DispatchLoop::excuse_own_absence() {
  const double absent = now() - std::exchange(last_tick_, now());
  if (absent < kAbsentSeconds) return;
  for (const auto& [id, session] : by_id_) session->heard = std::min(now(), session->heard + absent);
  scheduler_.excuse(absent, now());
}

void DispatchLoop::lose_silent() {
  const double latest = now() - options_.silence_seconds * (heard_all_ ? 1 : kDeafFactor);
  std::vector<Session*> silent;
  for (const auto& [id, session] : by_id_)
    if (session->heard < latest) silent.push_back(session);
  for (Session* session : silent) end_session(*session, Departure::kSilent, "nothing heard of it");
}

void DispatchLoop::expire_tasks() {
  for (const Scheduler::Hung& hung : scheduler_.expire(now())) {
    Session* session = find(hung.worker);
    if (session == nullptr) continue;
    sink_.event(
        true, "hung",
        "worker " + session->view.identity + ": task " + std::to_string(hung.task) + " is past its deadline");
    if (scheduler_.slots(hung.worker) > 0) continue;
    refuse(session->peer, "every slot of this worker hangs: restart it", false);
    end_session(*session, Departure::kLeft, "every slot hangs");
  }
  report_poisoned();
  send_idle_away();
}

void DispatchLoop::send_idle_away() {
  for (const WorkerId id : scheduler_.idle(now())) {
    Session* session = find(id);
    if (session == nullptr) continue;
    sink_.event(true, "idle", "worker " + session->view.identity + " holds tasks and starts none");
    refuse(session->peer, "this worker holds tasks and starts none: restart it", false);
    end_session(*session, Departure::kLeft, "starts none of its tasks");
  }
}

}  // namespace evograsp::server

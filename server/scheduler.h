// Who evaluates what next. A pure machine: no sockets, no threads, no clock (callers say what time it is), so
// that every decision can be tested. Its decisions change how long a generation takes, never what comes out
// of it: a trial is a pure function, and the first result of a task is as good as any other.
//
// Sizes: a task is a rectangle of networks x trials. Its size follows guided self-scheduling
// (Polychronopoulos and Kuck, 1987): the work left over (slots x kShare), at most `task_seconds` of work,
// never so small that sending it costs more than doing it. So tasks are large while there is much to do and
// all slots finish together.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/audit.h"

namespace evograsp::server {

using WorkerId = std::uint32_t;  // of a session: never reused

inline constexpr double kSmallestTask = 2.5e-4;  // s: below this, sending costs more than it spreads

struct SchedulerOptions {
  double task_seconds = 0.05;
  std::uint32_t credit = 2;  // tasks in flight a slot, at least
  double task_deadline = 30;
  std::uint32_t poison_strikes = 3;
  bool speculate = true;
};

// Networks x trials [first_trial, first_trial + trials), for one worker.
struct Assignment {
  std::uint64_t task = 0;
  std::uint32_t attempt = 0;
  std::vector<std::uint32_t> networks;  // indexes into the generation
  std::uint32_t first_trial = 0, trials = 0;
  bool suspect = false;
  std::uint32_t audit = 0;  // the case it gives an opinion on (server/audit.h); 0: ordinary work
};

// A network that is given up: it killed or hung workers (scheduler_suspects.cpp).
struct Poisoned {
  std::uint32_t network = 0;
  std::uint32_t workers = 0, hosts = 0;  // different ones that were lost with it
  std::uint32_t tries = 0;               // that ended so
  std::string bytes = {};                // its serialised proto::Network; added by the dispatcher
};

// How a worker's session ended.
enum class Departure {
  kLeft,    // said goodbye, was superseded or was sent away: nothing it held is to blame
  kSilent,  // nothing heard of it: frozen, or its link is cut. No strike, but what it held may be suspect
  kDied,    // its process ended: what it had started gets a strike
};

struct SchedulerCounts {
  std::uint64_t tasks = 0, requeued = 0, speculated = 0, late = 0, expired = 0, strikes = 0;
};

// Not thread-safe.
class Scheduler {
 public:
  explicit Scheduler(const SchedulerOptions& options);

  // Two sessions of one party never audit each other, and count once among those that a network killed.
  void join(WorkerId worker, std::uint32_t slots, Party party);
  void join(WorkerId worker, std::uint32_t slots) { join(worker, slots, Party(worker)); }
  // Whether the worker takes work now (from the start: yes). Who does not is not counted on.
  void set_active(WorkerId worker, bool active);
  // Everything the worker held goes back to the queue.
  void leave(WorkerId worker, Departure departure);
  // A heartbeat's round trip. It shares the connection with the tasks, so it grows with what is queued there;
  // credit therefore goes by the shortest of the last few. Otherwise a busy worker would be sent more because
  // it is busy.
  void set_round_trip(WorkerId worker, double seconds);

  // What the worker says that a grasp takes it; goes by that until it has been measured. Nonsense is ignored.
  void set_estimate(WorkerId worker, double trial_seconds);

  // Starts a generation of `networks` x `trials`; what was still outstanding of the last one is forgotten.
  // lifts: the trials are lift tests, which take a thousand times as long; what they cost is learnt apart.
  void begin(std::uint32_t networks, std::uint32_t trials, bool lifts = false);
  // Network `index` can be given out; bytes: its size on the wire.
  void add(std::uint32_t index, std::size_t bytes);
  // Drops all work: results that still come are late.
  void abandon();
  bool finished() const { return networks_left_ == 0; }

  // The worker's next task, or nothing: its credit is used up, or nothing suits it now.
  std::optional<Assignment> next(WorkerId worker, double now);
  // The assignment could not be sent: it goes back, blamelessly.
  void unsend(WorkerId worker, const Assignment& assignment);
  // A slot is at it. Only the first time that this is said counts.
  void started(WorkerId worker, std::uint64_t task, std::uint32_t attempt, double now);
  // A result of it came, wanted or not: its slot is free. Before find() and result().
  void came_back(WorkerId worker, std::uint64_t task, std::uint32_t attempt, double now);

  struct Accepted {
    Assignment assignment;
    std::vector<std::uint32_t> complete;  // networks that now have all their trials
    std::vector<WorkerId> cancel;         // other workers that hold a copy of the task
  };
  // The rectangle that (task, attempt) of this worker stands for; nothing when the result is late or unknown.
  std::optional<Assignment> find(WorkerId worker, std::uint64_t task, std::uint32_t attempt) const;
  // The result of a task that find() knows: accepted once. seconds: wall time the slot spent.
  Accepted result(WorkerId worker, std::uint64_t task, double seconds);
  // The worker could not do the task (bad bytes): a strike, and back to the queue.
  void failed(WorkerId worker, std::uint64_t task);

  // ---- deadlines (scheduler_deadlines.cpp) ----

  // A started task that is past its deadline: the worker's slot hangs.
  struct Hung {
    WorkerId worker = 0;
    std::uint64_t task = 0;
  };
  // The master itself did not run for so long: no task's deadline came nearer.
  void excuse(double seconds, double now);
  // Tasks beyond their deadline at `now`; each is taken from its worker, which loses a slot. Also those that
  // somebody else has brought meanwhile, which are nobody's strike.
  std::vector<Hung> expire(double now);
  // Workers that hold tasks which they have not started, and have neither started nor brought anything for a
  // deadline and a second: they are to leave(), blamelessly. Until such a party has brought something, nobody
  // waits for its opinion.
  std::vector<WorkerId> idle(double now);
  // Networks given up since the last call; they count as evaluated.
  std::vector<Poisoned> take_poisoned();

  // ---- audits (scheduler_audit.cpp) ----

  // How many parties are here that could give an opinion: 0, 1, or 2 for two and more.
  int auditors() const;
  // Somebody is here who could give an opinion and is none of `not_by`; of their hosts, too, when no other is
  // here.
  bool can_audit(const std::vector<Party>& not_by) const;
  // The piece is to be done once more, by none of `not_by`, as an opinion on case `audit`: on another host
  // than theirs while one is here. Its network, which must not be complete, is complete only after that.
  void audit(std::uint32_t audit, const Piece& piece, std::vector<Party> not_by);
  // Hosts whose workers are to be back, or to have loaded, in a moment: as long, they count as here.
  void await_hosts(std::set<std::uint64_t> hosts) { awaited_ = std::move(hosts); }
  void await_host(std::uint64_t host) { awaited_.insert(host); }
  // An opinion that nobody waits for any more is not asked for if that has not been done yet.
  void withdraw_audit(std::uint32_t audit);
  struct Skipped {
    std::vector<std::uint32_t> audits;
    std::vector<std::uint32_t> complete;  // networks that now have all they are going to get
    bool disputed = false;                // a dispute waits for somebody who can decide it
    bool waiting = false;                 // another audit waits for somebody who can do it
  };
  // Gives up audits for which there is nobody, once nothing else is left to do; patient: none yet, somebody
  // may be back at once. Disputes are not given up.
  Skipped skip_audits(bool patient = false);
  // The piece of a network, complete or not, is to be done again from the start. False: it was given up.
  bool redo(const Piece& piece);

  std::uint32_t outstanding(WorkerId worker) const;
  std::uint32_t slots(WorkerId worker) const;
  std::uint32_t total_slots() const { return total_slots_; }
  double trial_seconds() const { return trial_seconds_[0]; }  // of grasps
  double trial_seconds(WorkerId worker) const;                // measured, declared, or 0
  void count_late() { ++counts_.late; }
  const SchedulerCounts& counts() const { return counts_; }

 private:
  struct Unit {  // consecutive trials of one network
    std::uint32_t network, first, count;
    std::uint32_t audit = 0;
  };
  struct Attempt {
    WorkerId worker;
    std::uint32_t number;
    double sent;
    double started = -1;
  };
  struct Forgotten {  // an attempt that had started when its task was done or dropped: it has a slot
    std::uint64_t task;
    std::uint32_t number;
    double started;
  };
  struct Task {
    Assignment what;
    std::vector<Attempt> attempts;  // now running or queued somewhere
    std::size_t bytes = 0;          // of its networks
    std::uint32_t next_attempt = 0;
  };
  struct Worker {
    std::uint32_t slots = 0;
    Party party;
    bool active = true;
    std::vector<std::uint64_t> tasks;       // in the order sent
    std::size_t bytes = 0;                  // of the networks in `tasks`
    std::deque<double> round_trips;         // s, the last few
    std::array<double, 2> trial_seconds{};  // of grasps, of lifts; 0: not measured yet
    double estimate = 0;                    // of grasps, its own; 0: none
    bool exclusive = false;                 // holds a suspect, and nothing else
    std::vector<Forgotten> forgotten;
    double moved = 0;  // s; started or brought something last
  };
  // What a network has done to workers.
  struct Try {
    Party party;
    bool strike = false;  // the worker died, hung or failed; otherwise it fell silent
  };
  struct Record {
    std::vector<Try> tries;   // that lost their worker
    std::uint8_t losses = 0;  // workers lost while holding it, started or not
    bool given_up = false;
  };

  std::uint32_t credit(const Worker& worker) const;
  bool full(const Worker& worker) const;
  double cost(const Worker& worker) const;
  std::uint32_t task_trials(const Worker& worker) const;
  Assignment cut(WorkerId id, const Worker& worker);
  bool take_whole(Assignment& what, std::uint32_t target);
  std::map<WorkerId, Unit>::iterator largest_rest();
  void give_up_rest(WorkerId worker);
  std::optional<Assignment> next_suspect(WorkerId id, Worker& worker, double now);
  std::optional<Assignment> next_audit(WorkerId id, Worker& worker, double now);
  bool suits(const Worker& worker, const Unit& unit) const;
  void count(WorkerId id, const Worker& worker);
  bool another_host(const std::vector<Party>& heard) const;
  bool may(const Worker& worker, const std::vector<Party>& not_by) const;
  bool may(const Worker& worker, std::uint32_t audit) const;
  bool gives_opinions(const Worker& worker) const;
  void forget(const Task& task, const Attempt& attempt);
  bool is_suspect(std::uint32_t network) const;
  bool only_audits_left() const;
  void forget_audit(const Unit& unit, std::vector<std::uint32_t>& complete);
  struct Times {
    double back = 0, overdue = 0;
  };
  Times times(const Task& task) const;
  Task* straggler(WorkerId id, double now);
  Assignment give(WorkerId id, Worker& worker, Task& task, double now);
  // Takes the attempt of this worker off the task; without attempts left the task ends and its work is
  // queued.
  void end_attempt(WorkerId id, Worker& worker, std::uint64_t task);
  void requeue(const Assignment& what);
  void blame(const Assignment& what, const Attempt& attempt, const Worker& by, Departure departure);
  void add_try(const Assignment& what, Party party, bool strike);
  bool is_enough(const Record& record) const;
  void learn(Worker& worker, double seconds, std::size_t trials);
  void poison(std::uint32_t network);

  SchedulerOptions options_;
  std::map<WorkerId, Worker> workers_;
  std::map<std::uint64_t, std::map<WorkerId, std::uint64_t>> able_;  // by host: identities that take work now
  std::set<std::uint64_t> awaited_;
  std::optional<std::uint64_t> first_host_;  // that ever joined
  bool many_hosts_ = false;                  // another has joined since
  std::uint32_t total_slots_ = 0;
  std::array<double, 2> trial_seconds_;  // as in Worker
  std::size_t kind_ = 0;                 // of the work at hand: 0 grasps, 1 lifts

  std::uint32_t trials_ = 0;
  std::uint32_t networks_left_ = 0;
  std::uint64_t trials_pending_ = 0;  // in the queues or not added yet
  std::vector<std::uint32_t> left_;   // trials missing, by network
  std::vector<Record> records_;       // by network
  std::vector<std::uint32_t> bytes_;  // by network
  std::deque<Unit> queue_;
  // What is left of a network that a worker began: its next tasks come from there, so that it is sent the
  // network once.
  std::map<WorkerId, Unit> rests_;
  std::deque<Unit> suspects_;
  std::deque<Unit> audits_;                             // to be given out
  std::map<std::uint32_t, std::vector<Party>> not_by_;  // by audit
  std::unordered_map<std::uint64_t, Task> tasks_;
  std::uint64_t next_task_ = 1;
  std::set<Party> idle_;       // left work lying, and have brought nothing since
  double no_idle_before_ = 0;  // as the next
  double no_hung_before_ = 0;  // nor can one be past its deadline: tens of thousands need not be looked at
  double no_straggler_before_ = 0;  // until then no task is overdue: thousands of idle slots need not look
  std::vector<Poisoned> poisoned_;
  SchedulerCounts counts_;
};

}  // namespace evograsp::server

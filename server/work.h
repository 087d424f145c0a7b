// What the run loop asks of the workers, and how the answers come back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "common/result.h"
#include "proto/wire.pb.h"
#include "server/scheduler.h"

namespace evograsp::server {

// The trials of a generation (or of a validation): the same for each of its networks.
struct Work {
  std::uint32_t generation = 0;
  std::uint64_t trial_set = 0;  // names the list of trials: workers keep what they prepared for it
  std::vector<proto::TrialKey> trials;
  bool lifts = false;                  // the trials' keys say lift
  std::uint32_t networks = 0;          // how many will be added
  std::optional<double> noop_seconds;  // benchmarks: instead of simulating, wait so long a network
};

// A network as it travels: packed once, shared by every message that carries it.
struct NetworkFrame {
  std::uint64_t id = 0;  // genome id
  zmq::message_t bytes;  // packed (common/network_pack.h)
};

// A worker's session.
struct PeerView {
  std::string identity, host, build, state;
  std::uint32_t pid = 0, slots = 0, outstanding = 0;
  double joined = 0, heard = 0;  // Unix time, s
  double round_trip = 0;         // s
  std::uint64_t tasks = 0, trials = 0;
  double busy_seconds = 0;  // of its slots, wall
  double cpu_seconds = 0;
  double trial_seconds = 0;  // of a grasp: measured, or declared before that; 0: neither
};

// Who wants to know. Called on the dispatcher's thread; must not block.
class WorkSink {
 public:
  virtual ~WorkSink() = default;
  // All trials of network `index`, in trial order. Each network comes once, as evaluated or as poisoned,
  // unless it is retracted in between. An audited network comes when its audit is over.
  virtual void evaluated(std::uint32_t index, std::vector<proto::Measurement> measurements) = 0;
  virtual void poisoned(const Poisoned& network) = 0;
  // What evaluated() said of these networks came from a liar: it will be said again.
  virtual void retracted(const std::vector<std::uint32_t>& networks) = 0;
  virtual void finished() = 0;
  // Why a trial could not be held at all (NO_TRIAL): at most once a result.
  virtual void notice(const std::string& text) = 0;
  // Something an operator wants to know; kind is a fixed word (worker_joined, worker_lost, refused, hung,
  // ...).
  virtual void event(bool warning, const std::string& kind, const std::string& text) = 0;
  // A worker joined or went; state: active, draining, quarantined, gone.
  virtual void worker(const PeerView& worker) = 0;
  // The dispatcher cannot go on.
  virtual void broken(const Error& error) = 0;
};

// Counters since the start of this process, and what goes on now.
struct DispatchView {
  SchedulerCounts scheduler;
  std::uint64_t trials = 0, evaluations = 0;
  std::uint64_t tasks_done = 0, poisoned = 0;
  std::uint64_t refused = 0, malformed = 0, lost = 0;
  std::uint64_t audits = 0, audit_mismatches = 0, quarantined = 0;
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  double trial_seconds = 0;        // mean, of a slot
  double busy_seconds = 0;         // of all slots, wall
  std::uint64_t slots_wanted = 0;  // that the run could use (server/slot_hint.h); 0: not known yet
  bool paused = false;
  double seconds = 0;             // of the dispatcher's life when this was seen
  std::vector<PeerView> workers;  // those connected, then those quarantined
};

}  // namespace evograsp::server

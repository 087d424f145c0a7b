// What every network of a generation meets: the scene and the view of each trial, prepared once a process.
//
// Placements and view depend on the experiment and the trial key alone, so all networks and all slots share
// them.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "common/mutex.h"
#include "proto/wire.pb.h"
#include "sim/simulator.h"

namespace evograsp::worker {

// Immutable once prepared.
struct Scenario {
  int target = 0;
  bool lift = false;      // what is grasped is lifted, too
  bool approach = false;  // the measurement says where the hand pointed
  sim::Placements placements;
  sim::Info info;
  std::vector<float> inputs;  // the network's input vector
  std::string fault;          // not empty: there is no such trial, for this reason
};

// The scenarios of one list of trials. Thread-safe.
class TrialSet {
 public:
  // Prepares what is missing and waits for what other threads are preparing. In the order of the keys.
  std::vector<std::shared_ptr<const Scenario>> prepare(const sim::Simulator& simulator,
                                                       std::span<const proto::TrialKey* const> keys);

 private:
  using Key = std::tuple<std::uint64_t, std::uint32_t, std::uint32_t, bool, bool>;  // a trial key
  bool claim(const Key& key);
  void publish(const Key& key, std::shared_ptr<const Scenario> scenario);
  void give_back(const Key& key);
  std::shared_ptr<const Scenario> wait(const Key& key);  // throws when whoever prepared it failed

  Mutex mutex_;
  std::condition_variable prepared_;
  std::map<Key, std::shared_ptr<const Scenario>> scenarios_ GUARDED_BY(mutex_);  // null: somebody is at it
};

// The trial sets in use, by name; keeps the last few and frees the rest. Thread-safe.
class ScenarioCache {
 public:
  std::shared_ptr<TrialSet> get(std::uint64_t name);

 private:
  static constexpr std::size_t kKept = 3;
  Mutex mutex_;
  std::list<std::pair<std::uint64_t, std::shared_ptr<TrialSet>>> sets_
      GUARDED_BY(mutex_);  // the last used first
};

}  // namespace evograsp::worker

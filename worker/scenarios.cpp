#include "worker/scenarios.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace evograsp::worker {

namespace {

std::shared_ptr<const Scenario> make_scenario(const sim::Simulator& simulator, const proto::TrialKey& key) {
  auto scenario = std::make_shared<Scenario>();
  if (key.target() >= static_cast<std::uint32_t>(simulator.object_count())) {
    scenario->fault = "there is no object " + std::to_string(key.target());
    return scenario;
  }
  scenario->target = static_cast<int>(key.target());
  scenario->lift = key.lift();
  scenario->approach = key.approach();
  Result<sim::Placements> placements = simulator.shuffle(key.seed());
  if (!placements) {
    scenario->fault = placements.error().message;
    return scenario;
  }
  Result<sim::Info> info = simulator.get_info(*placements, scenario->target, static_cast<int>(key.click()),
                                              simulator.experiment().trials().bounding_box());
  if (!info) {
    scenario->fault = info.error().message;
    return scenario;
  }
  scenario->placements = std::move(*placements);
  scenario->info = std::move(*info);
  scenario->inputs.resize(static_cast<std::size_t>(simulator.inputs()));
  scenario->info.write_inputs(scenario->inputs);
  return scenario;
}

}  // namespace

std::vector<std::shared_ptr<const Scenario>> TrialSet::prepare(const sim::Simulator& simulator,
                                                               std::span<const proto::TrialKey* const> keys) {
  const auto key_of = [](const proto::TrialKey* k) {
    return Key{k->seed(), k->target(), k->click(), k->lift(), k->approach()};
  };
  for (const proto::TrialKey* key : keys) {
    if (!claim(key_of(key))) continue;
    try {
      publish(key_of(key), make_scenario(simulator, *key));
    } catch (...) {  // out of memory: whoever waits for it must not wait for ever
      give_back(key_of(key));
      throw;
    }
  }
  std::vector<std::shared_ptr<const Scenario>> scenarios;
  scenarios.reserve(keys.size());
  for (const proto::TrialKey* key : keys) scenarios.push_back(wait(key_of(key)));
  return scenarios;
}

bool TrialSet::claim(const Key& key) {
  const MutexLock lock(mutex_);
  return scenarios_.try_emplace(key).second;
}

void TrialSet::publish(const Key& key, std::shared_ptr<const Scenario> scenario) {
  {
    const MutexLock lock(mutex_);
    scenarios_[key] = std::move(scenario);
  }
  prepared_.notify_all();
}

void TrialSet::give_back(const Key& key) {
  {
    const MutexLock lock(mutex_);
    scenarios_.erase(key);
  }
  prepared_.notify_all();
}

std::shared_ptr<const Scenario> TrialSet::wait(const Key& key) {
  MutexLock lock(mutex_);
  for (;;) {
    const auto entry = scenarios_.find(key);
    if (entry == scenarios_.end()) throw std::runtime_error("a trial could not be prepared");
    if (entry->second != nullptr) return entry->second;
    lock.wait(prepared_);
  }
}

std::shared_ptr<TrialSet> ScenarioCache::get(std::uint64_t name) {
  const MutexLock lock(mutex_);
  const auto found =
      std::find_if(sets_.begin(), sets_.end(), [&](const auto& set) { return set.first == name; });
  if (found != sets_.end()) {
    sets_.splice(sets_.begin(), sets_, found);
  } else {
    sets_.emplace_front(name, std::make_shared<TrialSet>());
    if (sets_.size() > kKept) sets_.pop_back();
  }
  return sets_.front().second;
}

}  // namespace evograsp::worker

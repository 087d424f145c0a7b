#include "common/task_memory.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/wire.h"

namespace evograsp {

// ---- NetworkMemory ----

bool NetworkMemory::has(std::uint64_t network) const {
  return std::any_of(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.network == network; });
}

zmq::message_t NetworkMemory::share(std::uint64_t network) {
  const auto kept =
      std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.network == network; });
  return evograsp::share(kept->bytes);
}

void NetworkMemory::add(std::uint64_t network, zmq::message_t bytes, std::size_t size) {
  kept_.push_back({network, size, std::move(bytes)});
  bytes_ += size;
  while (kept_.size() > 1 && (kept_.size() > kMostNetworks || bytes_ > kMostBytes)) {
    bytes_ -= kept_.front().size;
    kept_.pop_front();
  }
}

void NetworkMemory::clear() {
  kept_.clear();
  bytes_ = 0;
}

// ---- TaskMemory ----

namespace {

tl::unexpected<Error> bad(const proto::Task& task, const char* what) {
  return fail(ErrorCode::kInvalid, "task " + std::to_string(task.id()) + " " + what);
}

}  // namespace

Status TaskMemory::complete(proto::Task& task, std::vector<zmq::message_t>& body) {
  if (task.trial_size() > 0) {
    trials_.assign(task.trial().begin(), task.trial().end());
    networks_.clear();
  }
  const std::size_t first = task.first_trial(), count = task.trials();
  if (first > trials_.size() || count > trials_.size() - first)
    return bad(task, "names trials that were never sent");
  task.clear_trial();
  for (std::size_t i = first; i < first + count; ++i) *task.add_trial() = trials_[i];
  return complete_networks(task, body);
}

// What is known is looked up before anything new is kept, as the master does.
Status TaskMemory::complete_networks(const proto::Task& task, std::vector<zmq::message_t>& body) {
  const auto count = static_cast<std::size_t>(task.network_size());
  if (count != body.size() + static_cast<std::size_t>(task.known_size()))
    return bad(task, "does not come with as many networks as it says");
  std::vector<zmq::message_t> all(count);
  std::vector<bool> known(count, false);
  for (const std::uint32_t place : task.known()) {
    if (place >= count || known[place] || !networks_.has(task.network(static_cast<int>(place))))
      return bad(task, "builds on a network that was never sent");
    known[place] = true;
    all[place] = networks_.share(task.network(static_cast<int>(place)));
  }
  auto came = body.begin();
  for (std::size_t i = 0; i < count; ++i) {
    if (known[i]) continue;
    networks_.add(task.network(static_cast<int>(i)), share(*came), came->size());
    all[i] = std::move(*came++);
  }
  body = std::move(all);
  return {};
}

void TaskMemory::clear() {
  trials_.clear();
  networks_.clear();
}

}  // namespace evograsp

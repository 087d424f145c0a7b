#include "common/strangers.h"

#include <algorithm>
#include <chrono>

namespace evograsp {

namespace {

// Of a connection that was over before it could be asked.
constexpr char kUnknownAddress[] = "somebody who was gone at once";

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

const char* to_string(Offence offence) {
  constexpr const char* kWords[kOffences] = {"handshake", "key",    "frame", "flood",  "hello",
                                             "token",     "origin", "path",  "request"};
  return kWords[static_cast<std::size_t>(offence)];
}

Strangers::Strangers() : Strangers(Limits(), steady_seconds) {}

Strangers::Strangers(Limits limits, Clock clock)
    : limits_(limits),
      clock_(std::move(clock)),
      lines_(limits.burst, limits.seconds),
      next_forgotten_(clock_() + limits.again) {}

std::optional<std::string> Strangers::note(Offence offence, const std::string& address,
                                           const std::string& what) {
  const double now = clock_();
  const MutexLock lock(mutex_);
  ++counts_[static_cast<std::size_t>(offence)];
  Entry& entry = entry_of(offence, address.empty() ? kUnknownAddress : address, now);
  ++entry.untold;
  entry.what = what;
  return now < entry.due ? std::nullopt : line_of(entry, now);
}

// The entry, in front.
Strangers::Entry& Strangers::entry_of(Offence offence, const std::string& address, double now) {
  std::string key = to_string(offence) + (' ' + address);
  const auto found = by_key_.find(key);
  if (found != by_key_.end()) {
    entries_.splice(entries_.begin(), entries_, found->second);
    return *found->second;
  }
  if (entries_.size() >= limits_.addresses) {
    forgotten_ += entries_.back().untold;
    by_key_.erase(entries_.back().key);
    entries_.pop_back();
  }
  entries_.push_front({key, address, {}, 0, 0, now});
  by_key_.emplace(std::move(key), entries_.begin());
  return entries_.front();
}

// Nothing while all addresses together have said too much: the offence stays untold.
std::optional<std::string> Strangers::line_of(Entry& entry, double now) {
  if (!lines_.allow(now)) return std::nullopt;
  std::string line = entry.address + ": " + entry.what;
  if (entry.untold > 1) line += ", and " + std::to_string(entry.untold - 1) + " more";
  const bool was_quiet = now > entry.due + entry.pause;
  entry.pause = entry.pause == 0 || was_quiet ? limits_.again : std::min(2 * entry.pause, limits_.longest);
  entry.due = now + entry.pause;
  entry.untold = 0;
  return line;
}

std::vector<std::string> Strangers::sums() {
  const double now = clock_();
  const MutexLock lock(mutex_);
  std::vector<std::string> lines;
  for (Entry& entry : entries_) {
    if (entry.untold == 0 || now < entry.due) continue;
    auto line = line_of(entry, now);
    if (!line) break;
    lines.push_back(std::move(*line));
  }
  if (forgotten_ > 0 && now >= next_forgotten_) {
    lines.push_back("more addresses than are kept apart: " + std::to_string(forgotten_) +
                    " refusals beside those named");
    forgotten_ = 0;
    next_forgotten_ = now + limits_.again;
  }
  return lines;
}

void Strangers::tell(Offence offence, const std::string& address, const std::string& what) {
  if (const auto line = note(offence, address, what)) spdlog::warn("refused: {}", *line);
}

Strangers::Counts Strangers::counts() const {
  const MutexLock lock(mutex_);
  return counts_;
}

std::size_t Strangers::addresses() const {
  const MutexLock lock(mutex_);
  return entries_.size();
}

}  // namespace evograsp

// Looking for a master: where a rendezvous says one is, for how long, and why none will have this worker.
#include <chrono>
#include <string>

#include "common/log.h"
#include "common/rendezvous.h"
#include "worker/session.h"

namespace evograsp::worker {

namespace {

constexpr std::chrono::seconds kWarnAgain(60);
constexpr std::chrono::seconds kAlone(5);  // without a master until that is worth a line

// Why a master and this worker came to nothing, and what to look at.
const char* cause_of(FailedHandshake::Why why, bool has_keys) {
  switch (why) {
    case FailedHandshake::Why::kNotListed:
      return "the master refused this worker's key: is its public key on the master's allow-list?";
    case FailedHandshake::Why::kMechanism:
      return has_keys ? "this worker has keys (CURVE), what listens there has none"
                      : "the master refuses peers without keys (CURVE): give this worker a --curve-key-file";
    case FailedHandshake::Why::kGone:
      return has_keys ? "hung up or fell silent during the handshake: is the server-key in the key file the "
                        "master's public key, and is an evograsp master there?"
                      : "hung up or fell silent during the handshake: is an evograsp master there?";
    default:
      return "what listens there is no evograsp master";
  }
}

}  // namespace

// Where the master is: false while nobody says so.
bool Session::find_master() {
  if (options_.rendezvous.empty()) return true;
  const auto where = read_rendezvous(options_.rendezvous);
  if (where && !where->connect.empty()) {
    endpoint_ = where->connect;
    return true;
  }
  if (where) {
    if (options_.once) spdlog::info("{}: {}", options_.rendezvous, where->over);
    done_ = done_ || options_.once;
    return false;
  }
  if (where.error().code != ErrorCode::kNotFound) give_up(where.error());
  return false;
}

void Session::check_absence() {
  const bool looking = !connected_ || state_ == State::kGreeting;
  if (looking && !alone_said_ && Clock::now() - served_ > kAlone) {
    alone_said_ = true;
    if (!options_.rendezvous.empty() &&
        read_rendezvous(options_.rendezvous).value_or(Rendezvous()).connect.empty())
      spdlog::warn("{}: does not say where a master is: still looking", options_.rendezvous);
    else
      spdlog::warn("no master answers at {}: still looking", endpoint_);
  }
  if (options_.wait_seconds <= 0 ||
      Clock::now() - served_ < std::chrono::duration<double>(options_.wait_seconds))
    return;
  const std::string where = options_.rendezvous.empty() ? endpoint_ : options_.rendezvous;
  give_up({ErrorCode::kUnavailable,
           where + ": no master for " + std::to_string(static_cast<int>(options_.wait_seconds)) + " s"});
}

// Tries go on: keys may be listed, and masters started, later. Said once, and again after a while.
void Session::warn_of(FailedHandshake::Why why) {
  if (warned_of_ == why && Clock::now() < next_warning_) return;
  warned_of_ = why;
  next_warning_ = Clock::now() + kWarnAgain;
  spdlog::warn("{}: {}; trying again", endpoint_, cause_of(why, options_.curve.has_value()));
}

}  // namespace evograsp::worker

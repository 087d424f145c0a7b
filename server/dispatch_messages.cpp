// What peers say, and what is believed of it.
#include <algorithm>
#include <utility>

#include "common/version.h"
#include "server/dispatch_loop.h"
#include "server/store_records.h"

namespace evograsp::server {

namespace {

constexpr std::uint32_t kMaxSlots = 4096;
constexpr std::size_t kMaxName = 200;
constexpr double kScoldEvery = 0.1;    // s, for the same stranger
constexpr int kHellos = 5;             // of one connection at once
constexpr double kHelloSeconds = 0.5;  // and then one in so long: who loses a connection comes by another

// Names come from strangers and end in logs: short, printable, one line.
std::string clean(const std::string& name) {
  std::string text = name.substr(0, kMaxName);
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return text;
}

}  // namespace

void DispatchLoop::handle(Received& message) {
  const auto session = sessions_.find(message.peer);
  if (!message.fault.empty()) {
    misbehaved(message, message.fault);
  } else if (session == sessions_.end() || message.envelope->has_hello()) {
    handle_stranger(message);
  } else {
    session->second->heard = now();
    session->second->view.heard = unix_time();
    handle_session(*session->second, message);
  }
}

// Without a session only a Hello means anything.
void DispatchLoop::handle_stranger(Received& message) {
  drop_disconnected();  // the descriptor may have belonged to another connection a moment ago
  monitor_.spoke(message.fd);
  if (message.envelope->has_hello()) {
    if (knocks_too_often(message)) return;
    message.envelope->hello().stepwise() ? on_client_hello(message) : on_hello(message);
    return;
  }
  const auto client = clients_.find(message.peer);
  if (client != clients_.end() && message.envelope->has_step_request()) {
    on_step_request(message.peer, client->second, message.envelope->step_request());
  } else if (client != clients_.end() && message.envelope->has_asset_request()) {
    on_asset_request(message);
  } else {
    refuse(message.peer, "no session: say hello", true);
  }
}

// Each hello ends a session and begins one.
bool DispatchLoop::knocks_too_often(const Received& message) {
  if (hellos_.try_emplace(message.peer, kHellos, kHelloSeconds).first->second.allow(now())) return false;
  turn_away(message.address, "a connection says hello over and over");
  refuse(message.peer, "too many hellos: wait a moment", true);
  return true;
}

void DispatchLoop::handle_session(Session& session, const Received& message) {
  const proto::Envelope& envelope = *message.envelope;
  if (SessionStamp{envelope.run(), envelope.epoch()} != options_.stamp) return;  // from another master's days
  if (!message.attachments.empty()) return misbehaved(session, "attachments where none belong");
  switch (envelope.body_case()) {
    case proto::Envelope::kAssetRequest:
      return on_asset_request(message);
    case proto::Envelope::kReady:
      return on_ready(session, envelope.ready());
    case proto::Envelope::kStarted:
      return scheduler_.started(session.id, envelope.started().id(), envelope.started().attempt(), now());
    case proto::Envelope::kResult:
      return on_result(session, envelope.result());
    case proto::Envelope::kStepReply:
      return on_step_reply(session, envelope.step_reply());
    case proto::Envelope::kHeartbeat:
      return on_heartbeat(session, envelope.heartbeat());
    case proto::Envelope::kDrain:
      session.leaving = true;
      session.view.state = "draining";
      scheduler_.set_active(session.id, false);
      return sink_.worker(session.view);
    case proto::Envelope::kGoodbye:
      return on_goodbye(session, envelope.goodbye());
    default:
      return misbehaved(session, "a message that only a master sends");
  }
}

// ---- joining ----

void DispatchLoop::on_hello(const Received& message) {
  const proto::Hello& hello = message.envelope->hello();
  const std::string& peer = message.peer;
  if (!message.attachments.empty() || hello.slots() < 1 || hello.slots() > kMaxSlots ||
      hello.identity().empty() || hello.identity().size() > kMaxName)
    return misbehaved(message, "a hello without identity, or with no or too many slots");
  if (hello.build() != kVersion) {
    const std::string reason = "worker build " + clean(hello.build()) + ", master build " + kVersion +
                               ": install the same version on both sides";
    turn_away(message.address, "worker " + clean(hello.identity()) + ": " + reason);
    return refuse(peer, reason, false);
  }
  if (refuse_quarantined(clean(hello.identity()), message) || !supersede(message)) return;

  auto session = std::make_unique<Session>();
  session->peer = peer;
  session->address = message.address;
  session->id = next_id_++;
  session->fd = message.fd;
  session->heard = session->began = now();
  PeerView& view = session->view;
  view.identity = clean(hello.identity());
  view.host = clean(hello.host());
  view.build = clean(hello.build());
  view.state = "active";
  view.pid = hello.pid();
  view.slots = hello.slots();
  view.joined = view.heard = unix_time();
  const std::hash<std::string> hash;
  session->party = Party(hash(view.identity), hash(view.host));
  scheduler_.join(session->id, hello.slots(), session->party);
  scheduler_.set_active(session->id, false);  // until its simulator stands
  by_id_[session->id] = session.get();
  sink_.worker(view);
  list(false, "worker_joined",
       "worker " + view.identity + " on " + view.host + " with " + std::to_string(view.slots) +
           (view.slots == 1 ? " slot" : " slots"));
  follow_drain(*session);
  sessions_[peer] = std::move(session);
  welcome(peer);
  if (!dismissed_.empty()) tell_dismissed(peer);
}

// One identity, one session. The same process coming back replaces what is left of it; another process is
// told that the name is taken, until the first one is gone.
bool DispatchLoop::supersede(const Received& message) {
  const proto::Hello& hello = message.envelope->hello();
  const std::string& peer = message.peer;
  const std::string identity = clean(hello.identity());
  // Two at most: one of this name, one of this connection under another name.
  std::vector<Session*> before;
  for (const auto& [id, session] : by_id_)
    if (session->view.identity == identity || session->peer == peer) before.push_back(session);
  for (const Session* old : before) {
    if (old->peer == peer || (old->view.pid == hello.pid() && old->view.host == clean(hello.host())))
      continue;
    const std::string reason = "identity " + identity + " is in use by process " +
                               std::to_string(old->view.pid) + " on " + old->view.host +
                               ": start this worker with another --identity";
    turn_away(message.address, reason);
    refuse(peer, reason, true);
    return false;
  }
  for (Session* old : before) end_session(*old, Departure::kSilent, "came back over a new connection");
  return true;
}

void DispatchLoop::welcome(const std::string& peer) {
  proto::Envelope envelope = make_envelope(options_.stamp);
  proto::Welcome& welcome = *envelope.mutable_welcome();
  *welcome.mutable_experiment() = options_.experiment;
  welcome.set_heartbeat_seconds(options_.heartbeat_seconds);
  welcome.set_silence_seconds(options_.silence_seconds);
  welcome.set_credit(options_.scheduler.credit);
  send(router_, peer, envelope);
}

void DispatchLoop::refuse(const std::string& peer, const std::string& reason, bool retry) {
  proto::Envelope envelope = make_envelope(options_.stamp);
  envelope.mutable_refusal()->set_reason(reason);
  envelope.mutable_refusal()->set_retry(retry);
  send(router_, peer, envelope);
}

// A worker that must not join.
void DispatchLoop::turn_away(const std::string& address, const std::string& text) {
  ++totals_.refused;
  complain(Offence::kHello, "refused", address, text);
}

// Costs the sender its session, if it has one.
void DispatchLoop::misbehaved(const Received& message, const std::string& fault) {
  const auto session = sessions_.find(message.peer);
  if (session != sessions_.end()) return misbehaved(*session->second, fault);
  drop_disconnected();
  monitor_.spoke(message.fd);
  ++totals_.malformed;
  complain(Offence::kFrame, "malformed", message.address, "a stranger sent " + fault);
  if (message.peer == scolded_ && now() < scold_again_) return;  // who floods is not answered each time
  scolded_ = message.peer;
  scold_again_ = now() + kScoldEvery;
  refuse(message.peer, "refused: " + fault, false);
}

void DispatchLoop::misbehaved(Session& session, const std::string& fault) {
  ++totals_.malformed;
  complain(Offence::kFrame, "malformed", session.address,
           "worker " + session.view.identity + " sent " + fault);
  refuse(session.peer, "refused: " + fault, false);
  end_session(session, Departure::kLeft, "sent away");
  pump_all();
}

void DispatchLoop::on_asset_request(const Received& message) {
  const std::string& id = message.envelope->asset_request().id();
  const auto reply = asset_replies_.find(id);
  if (reply != asset_replies_.end()) {
    send(router_, message.peer, share(reply->second));
    return;
  }
  proto::Envelope envelope = make_envelope(options_.stamp);
  envelope.mutable_asset_reply()->set_id(clean(id));
  envelope.mutable_asset_reply()->set_found(false);
  send(router_, message.peer, envelope);
}

void DispatchLoop::on_ready(Session& session, const proto::Ready& ready) {
  if (ready.fingerprint() != options_.experiment.fingerprint()) {
    const std::string reason = "the worker's simulator is not the experiment's: fingerprint " +
                               clean(ready.fingerprint()) + " instead of " +
                               options_.experiment.fingerprint();
    turn_away(session.address, "worker " + session.view.identity + ": " + reason);
    refuse(session.peer, reason, false);
    return end_session(session, Departure::kLeft, "another experiment");
  }
  session.ready = true;
  scheduler_.set_estimate(session.id, ready.trial_seconds());
  scheduler_.set_active(session.id, session.view.state == "active");
  pump(session);
}

// ---- working ----

void DispatchLoop::on_result(Session& session, const proto::TaskResult& result) {
  scheduler_.came_back(session.id, result.id(), result.attempt(), now());
  const std::optional<Assignment> what = scheduler_.find(session.id, result.id(), result.attempt());
  if (!what) {
    scheduler_.count_late();
    return pump(session);
  }
  if (!result.error().empty()) {
    list(true, "task_failed", "worker " + session.view.identity + ": " + clean(result.error()));
    scheduler_.failed(session.id, result.id());
    report_poisoned();
    pump_all();
    return finish_if_done();
  }
  const std::size_t expected = what->networks.size() * what->trials;
  if (static_cast<std::size_t>(result.measurement_size()) != expected)
    return misbehaved(session, "a result of " + std::to_string(result.measurement_size()) +
                                   " measurements where " + std::to_string(expected) + " were asked for");
  if (!result.notice().empty()) sink_.notice(clean(result.notice()));
  const double seconds = static_cast<double>(result.wall_nanoseconds()) * 1e-9;
  book(session, *what, result);
  const Scheduler::Accepted accepted = scheduler_.result(session.id, result.id(), seconds);
  session.view.busy_seconds += seconds;
  session.view.cpu_seconds += static_cast<double>(result.cpu_nanoseconds()) * 1e-9;
  session.view.tasks += 1;
  session.view.trials += expected;
  totals_.busy_seconds += seconds;
  totals_.trials += expected;
  ++totals_.tasks_done;
  tell_complete(accepted.complete);
  cancel(accepted);
  if (liars_.empty())
    pump(session);
  else
    send_liars_away();
  skip_audits();
  finish_if_done();
}

void DispatchLoop::cancel(const Scheduler::Accepted& accepted) {
  for (const WorkerId id : accepted.cancel) {
    Session* other = find(id);
    if (other == nullptr) continue;
    proto::Envelope envelope = make_envelope(options_.stamp);
    envelope.mutable_cancel()->add_id(accepted.assignment.task);
    send(router_, other->peer, envelope);
  }
}

// What was not asked for, or answers an earlier question, says nothing of the way.
void DispatchLoop::on_heartbeat(Session& session, const proto::Heartbeat& heartbeat) {
  if (heartbeat.sequence() != session.ping || session.pong == session.ping) return;
  session.pong = session.ping;
  session.view.round_trip = now() - session.ping_sent;
  scheduler_.set_round_trip(session.id, session.view.round_trip);
}

void DispatchLoop::on_goodbye(Session& session, const proto::Goodbye& goodbye) {
  session.leaving = true;
  end_session(session, Departure::kLeft, "says goodbye: " + clean(goodbye.reason()));
  pump_all();
}

}  // namespace evograsp::server

#include "server/dispatch_loop.h"

#include <algorithm>
#include <utility>

#include "common/digest.h"
#include "common/network_pack.h"

namespace evograsp::server {

namespace {

constexpr int kMessagesATurn = 512;
constexpr double kPatienceSeconds = 2;  // without workers, before it is worth a line in the log
constexpr double kPingEvery = 4;        // heartbeats, of a worker that is sent other things
constexpr std::size_t kManyWorkers = 256;
constexpr double kManyWorkersPump = 0.1;  // s
constexpr double kFloodLook = 0.04;       // s
constexpr double kFloodLookEach = 2e-5;   // s; of this thread's time, a twentieth at most
constexpr std::uint64_t kMostUnread = std::uint64_t{8}
                                      << 20;  // bytes; as empty frames, 30 times as much memory
constexpr double kSumsEvery = 1;              // s

// As a file or a person wants it; as it came when it is no packed network (benchmarks).
std::string plain_network(const zmq::message_t& bytes) {
  const auto network = unpack_network(bytes.to_string_view());
  return network ? deterministic_bytes(network->to_proto()) : bytes.to_string();
}

// What went out with the task is the worker's now; what was known already stays as it is.
void note_sent(const proto::Task& task, const Assignment& what, std::span<const NetworkFrame> networks,
               NetworkMemory& has) {
  int known = 0;
  for (int i = 0; i < task.network_size(); ++i) {
    if (known < task.known_size() && task.known(known) == static_cast<std::uint32_t>(i)) {
      ++known;
      continue;
    }
    has.add(task.network(i), {}, networks[what.networks[static_cast<std::size_t>(i)]].bytes.size());
  }
}

}  // namespace

DispatchLoop::DispatchLoop(zmq::context_t& context, zmq::socket_t router, DispatcherOptions options,
                           WorkSink& sink)
    : options_(std::move(options)),
      sink_(sink),
      router_(std::move(router)),
      monitor_(context, router_),
      scheduler_(options_.scheduler) {
  if (!options_.strangers) options_.strangers = std::make_shared<Strangers>();
  for (const ServedAsset& asset : options_.assets) {
    proto::Envelope envelope = make_envelope(options_.stamp);
    proto::AssetReply& reply = *envelope.mutable_asset_reply();
    reply.set_id(asset.id);
    reply.set_found(true);
    reply.set_compressed(true);
    asset_replies_.emplace(asset.id, to_frame(envelope, {asset.packed}));
  }
  if (options_.stamp.epoch > 1) parted_ = 0;  // workers of the last master's are on their way back
}

double DispatchLoop::now() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

Session* DispatchLoop::find(WorkerId id) {
  const auto found = by_id_.find(id);
  return found == by_id_.end() ? nullptr : found->second;
}

// ---- work ----

void DispatchLoop::begin(Work work) {
  work_ = std::move(work);
  ++work_number_;
  networks_.clear();
  networks_.resize(work_.networks);
  measurements_.clear();
  measurements_.resize(work_.networks);
  told_.assign(work_.networks, 0);
  auditor_.begin();
  names_.clear();
  said_disputed_ = false;
  scheduler_.begin(work_.networks, static_cast<std::uint32_t>(work_.trials.size()), work_.lifts);
  working_ = true;
  busy_before_ = totals_.busy_seconds;
  hint_.begin(now(), static_cast<std::uint64_t>(work_.networks) * work_.trials.size());
}

void DispatchLoop::add(std::uint32_t first, std::vector<NetworkFrame> networks) {
  for (NetworkFrame& network : networks) {
    if (first >= networks_.size()) return;  // of work that has been abandoned
    networks_[first] = std::move(network);
    scheduler_.add(first, networks_[first].bytes.size());
    ++first;
  }
  pump_all();
}

void DispatchLoop::abandon() {
  scheduler_.abandon();
  working_ = false;
  networks_.clear();
  measurements_.clear();
  auditor_.begin();
  proto::Envelope envelope = make_envelope(options_.stamp);
  envelope.mutable_cancel();  // of everything
  for (const auto& [id, session] : by_id_) send(router_, session->peer, envelope);
}

void DispatchLoop::set_paused(bool paused) {
  paused_ = paused;
  if (!paused) pump_all();
}

void DispatchLoop::dismiss(const std::string& reason) {
  dismissed_ = reason;
  for (const auto& [id, session] : by_id_) {
    tell_dismissed(session->peer);
    sink_.worker(session->view);  // what it has done, for the record
  }
}

void DispatchLoop::tell_dismissed(const std::string& peer) {
  proto::Envelope envelope = make_envelope(options_.stamp);
  envelope.mutable_drain()->set_reason(dismissed_);
  send(router_, peer, envelope);
}

// ---- giving out ----

void DispatchLoop::pump(Session& session) {
  while (give_one(session)) {
  }
}

// One task a turn, so that work is spread before it is stacked.
void DispatchLoop::pump_all() {
  bool given = true;
  while (given) {
    given = false;
    for (auto at = by_id_.begin(); at != by_id_.end();) {
      Session& session = *at->second;
      ++at;  // a worker found gone leaves the map
      given = give_one(session) || given;
    }
  }
}

bool DispatchLoop::give_one(Session& session) {
  if (!working_ || paused_ || !session.ready || session.view.state != "active") return false;
  const std::optional<Assignment> what = scheduler_.next(session.id, now());
  if (!what) return false;
  switch (send_task(session, *what)) {
    case SendResult::kSent:
      return true;
    case SendResult::kFull:
      scheduler_.unsend(session.id, *what);
      return false;
    case SendResult::kGone:
      scheduler_.unsend(session.id, *what);
      end_session(session, how_it_went(session), "its connection is gone");
      return false;
  }
  return false;
}

// What the worker has is left out (common/task_memory.h).
SendResult DispatchLoop::send_task(Session& session, const Assignment& what) {
  proto::Envelope envelope = make_envelope(options_.stamp);
  proto::Task& task = *envelope.mutable_task();
  task.set_id(what.task);
  task.set_attempt(what.attempt);
  task.set_generation(work_.generation);
  task.set_trial_set(work_.trial_set);
  if (what.suspect) task.set_suspect(true);
  if (work_.noop_seconds) task.set_noop_seconds(*work_.noop_seconds);
  const bool anew = session.work != work_number_;
  if (anew) task.mutable_trial()->Add(work_.trials.begin(), work_.trials.end());
  task.set_first_trial(what.first_trial);
  task.set_trials(what.trials);
  std::vector<std::string_view> packed;
  packed.reserve(what.networks.size());
  for (const std::uint32_t network : what.networks) {
    if (!anew && session.has.has(networks_[network].id)) {
      task.add_known(static_cast<std::uint32_t>(task.network_size()));
    } else {
      packed.push_back(networks_[network].bytes.to_string_view());
    }
    task.add_network(networks_[network].id);
  }
  zmq::message_t frame = to_frame(envelope, packed);
  const std::size_t bytes = frame.size();
  const SendResult result = send(router_, session.peer, std::move(frame));
  if (result != SendResult::kSent) return result;
  totals_.bytes_sent += bytes;
  session.told = now();
  if (anew) session.has.clear();
  session.work = work_number_;
  note_sent(task, what, networks_, session.has);
  return result;
}

void DispatchLoop::tell_complete(const std::vector<std::uint32_t>& networks) {
  for (const std::uint32_t network : networks) {
    ++totals_.evaluations;
    told_[network] = 1;
    sink_.evaluated(network, std::move(measurements_[network]));
  }
}

void DispatchLoop::finish_if_done() {
  if (!working_ || !scheduler_.finished()) return;
  working_ = false;
  hint_.finish(now(), totals_.busy_seconds - busy_before_,
               std::max(kSmallestTask, scheduler_.trial_seconds()));
  sink_.finished();
}

void DispatchLoop::report_poisoned() {
  for (Poisoned& poisoned : scheduler_.take_poisoned()) {
    ++totals_.poisoned;
    told_[poisoned.network] = 1;
    poisoned.bytes = plain_network(networks_[poisoned.network].bytes);
    sink_.poisoned(poisoned);
  }
}

// ---- time ----

// To those who have not been sent anything for a while, and to everybody now and then, for the round trip:
// with thousands of busy workers, pings would be a good part of all messages.
void DispatchLoop::send_heartbeats() {
  std::vector<Session*> gone;
  for (const auto& [id, session] : by_id_) {
    const double quiet = now() - std::max(session->told, session->ping_sent);
    if (quiet < options_.heartbeat_seconds &&
        now() - session->ping_sent < kPingEvery * options_.heartbeat_seconds)
      continue;
    proto::Envelope envelope = make_envelope(options_.stamp);
    envelope.mutable_heartbeat()->set_sequence(++session->ping);
    session->ping_sent = now();
    if (send(router_, session->peer, envelope) == SendResult::kGone) gone.push_back(session);
  }
  for (Session* session : gone) end_session(*session, how_it_went(*session), "its connection is gone");
}

void DispatchLoop::tick() {
  excuse_own_absence();
  if (now() >= next_look_) {
    next_look_ = now() + options_.heartbeat_seconds;
    lose_silent();
    forget_idle_clients();
    std::erase_if(hellos_, [&](const auto& entry) { return entry.second.rested(now()); });
    say_unlisted();
  }
  sum_up_complaints();
  end_floods();
  send_heartbeats();
  expire_tasks();
  say_when_waiting();
  await_hosts();
  skip_audits();
  pump_now_and_then();
  finish_if_done();
}

// For overdue tasks, and for workers whose queue was full. Most work is given out where a result comes in.
void DispatchLoop::pump_now_and_then() {
  if (by_id_.size() > kManyWorkers && now() < next_pump_) return;
  next_pump_ = now() + kManyWorkersPump;
  pump_all();
}

// Counted each time, said now and then.
void DispatchLoop::complain(Offence offence, const char* kind, const std::string& address,
                            const std::string& text) {
  if (const auto line = options_.strangers->note(offence, address, text)) sink_.event(true, kind, *line);
}

void DispatchLoop::sum_up_complaints() {
  if (now() < next_sums_) return;
  next_sums_ = now() + kSumsEvery;
  for (const std::string& line : options_.strangers->sums()) sink_.event(true, "refused", line);
}

// Of one peer's bytes, so many wait here to be read; a frame of the largest size is one of them.
void DispatchLoop::end_floods() {
  if (now() < next_flood_look_) return;
  next_flood_look_ =
      now() + std::max(kFloodLook, kFloodLookEach * static_cast<double>(monitor_.connections()));
  const auto most =
      std::max<std::uint64_t>(kMostUnread, 2 * static_cast<std::uint64_t>(options_.socket.max_frame_bytes));
  for (const std::string& address : monitor_.end_floods(most))
    complain(Offence::kFlood, "refused", address,
             "at the worker port: sends faster than it is read, or a message without end");
}

void DispatchLoop::say_when_waiting() {
  const bool alone = working_ && by_id_.empty();
  if (!alone) {
    alone_since_ = -1;
    said_waiting_ = false;
  } else if (alone_since_ < 0) {
    alone_since_ = now();
  } else if (!said_waiting_ && now() - alone_since_ > kPatienceSeconds) {
    said_waiting_ = true;
    sink_.event(false, "waiting", "no worker is connected: waiting for one");
  }
}

bool DispatchLoop::receive_some() {
  Received message;
  for (int i = 0; i < kMessagesATurn; ++i) {
    heard_all_ = !receive(router_, true, arena_, message);
    if (heard_all_) return false;
    totals_.bytes_received += message.size;
    monitor_.read(message.fd, wire_size(message.size, options_.socket.curve.has_value()));
    handle(message);
    if (arena_.SpaceUsed() > (1 << 20)) arena_.Reset();
  }
  return true;
}

DispatchView DispatchLoop::view() const {
  DispatchView view = totals_;
  view.scheduler = scheduler_.counts();
  view.trial_seconds = scheduler_.trial_seconds();
  view.paused = paused_;
  view.seconds = now();
  view.slots_wanted = hint_.slots();
  for (const auto& [id, session] : by_id_) {
    view.workers.push_back(session->view);
    view.workers.back().outstanding = scheduler_.outstanding(id);
    view.workers.back().trial_seconds = scheduler_.trial_seconds(id);
  }
  for (const auto& [identity, worker] : quarantined_) view.workers.push_back(worker);
  return view;
}

}  // namespace evograsp::server

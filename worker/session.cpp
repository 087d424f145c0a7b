#include "worker/session.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <random>
#include <utility>

#include "common/counted.h"
#include "common/log.h"
#include "common/version.h"

namespace evograsp::worker {

namespace {

constexpr double kMostPatience = 1.0;  // s: a master that is back is found within this
constexpr double kSlowestTick = 0.1;
constexpr double kSignSeconds = 1;
constexpr double kReconnectPause = 0.1;
constexpr double kRendezvousPause = 0.5;  // s: the file may be on a file server that a thousand workers ask
// A task that runs this long is reported as started. Most are done by then, and their result says it all.
constexpr auto kReportStart = std::chrono::milliseconds(5);
constexpr double kAbsentSeconds = 0.2;  // between two looks: this thread did not run, and heard nothing
constexpr double kSlowestLink =
    256 << 10;                       // bytes a second: a message of this size may be on its way for a second
constexpr double kLastPatience = 2;  // s, for slots to finish what they do, when the worker ends

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<int>(seconds * 1000));
}

// A thousand workers shall not knock at once. Affects no result.
double jitter() {
  thread_local std::minstd_rand engine{std::random_device{}()};
  return 0.75 + 0.5 * static_cast<double>(engine() - std::minstd_rand::min()) /
                    static_cast<double>(std::minstd_rand::max() - std::minstd_rand::min());
}

}  // namespace

Session::Session(zmq::context_t& context, const WorkerOptions& options, std::shared_ptr<Wakeup> wakeup,
                 const std::atomic<int>& order)
    : context_(context),
      options_(options),
      wakeup_(std::move(wakeup)),
      order_(order),
      slots_(std::make_unique<SlotPool>(options.slots, wakeup_)),
      endpoint_(options.connect) {}

Session::~Session() {
  if (slots_->end(kLastPatience)) return;
  spdlog::warn("a slot hangs: left behind");
  static_cast<void>(slots_.release());
}

Status Session::run() {
  while (!done_)
    if (Status status = turn(); !status) return status;
  disconnect();
  if (error_) return tl::unexpected(*error_);
  return {};
}

Status Session::turn() {
  if (lost_) pause(kReconnectPause);
  lost_ = false;
  if (done_) return {};
  show_life();
  check_absence();
  if (!connected_ && !find_master()) {
    obey();
    pause(kRendezvousPause);
    return {};
  }
  if (!connected_)
    if (Status status = connect(); !status) return status;
  wait();
  send_events();
  read_all();
  obey();
  beat();
  check_connection();
  check_silence();
  return {};
}

// ---- connection ----

// To whoever watches: from this loop, since its progress is the worker's life.
void Session::show_life() {
  watchdog_.beat();
  if (options_.alive_file.empty() || Clock::now() < next_sign_) return;
  next_sign_ = Clock::now() + milliseconds(kSignSeconds);
  constexpr const char* kWords[] = {"looking", "loading", "serving", "draining"};
  std::ofstream sign(options_.alive_file);
  sign << kWords[static_cast<int>(state_)] << "\n" << std::flush;
  if (!sign && !std::exchange(sign_failed_, true))
    spdlog::warn("--alive-file {}: cannot be written: {}", options_.alive_file, std::strerror(errno));
}

Status Session::connect() {
  SocketOptions options;
  options.curve = options_.curve;
  auto socket = make_dealer(context_, endpoint_, options);
  if (!socket) return tl::unexpected(socket.error());
  socket_ = std::move(*socket);
  try {
    monitor_ = std::make_unique<ConnectionMonitor>(context_, socket_);
  } catch (const zmq::error_t& error) {  // no descriptors left
    return fail(ErrorCode::kUnavailable, endpoint_ + ": cannot watch the connection: " + error.what());
  }
  connected_ = true;
  lost_ = false;
  ++session_;
  state_ = State::kGreeting;
  heard_ = looked_ = Clock::now();
  largest_ = 0;
  memory_.clear();
  proto::Envelope envelope = make_envelope({});
  proto::Hello& hello = *envelope.mutable_hello();
  hello.set_build(kVersion);
  hello.set_host(options_.host);
  hello.set_pid(static_cast<std::uint32_t>(getpid()));
  hello.set_slots(static_cast<std::uint32_t>(options_.slots));
  hello.set_identity(options_.identity);
  hello.set_fingerprint(fingerprint_);
  send(socket_, {}, envelope);
  return {};
}

void Session::disconnect() {
  if (!connected_) return;
  monitor_.reset();
  socket_.close();
  connected_ = false;
  slots_->take_back();
  unfinished_ = 0;
  built_.reset();
}

// After a loss: what was given out by the old session is forgotten, the next try waits a little longer.
void Session::pause(double seconds) {
  disconnect();
  if (done_) return;
  const auto until = Clock::now() + milliseconds(seconds * jitter());
  while (Clock::now() < until && order_ == kServe) {
    zmq::pollitem_t item{nullptr, wakeup_->fd(), ZMQ_POLLIN, 0};
    zmq::poll(&item, 1, milliseconds(0.02));
    if (item.revents != 0) wakeup_->clear();
  }
  slots_->take_events();
  patience_ = std::min(patience_ * 1.5, kMostPatience);
}

void Session::wait() {
  zmq::pollitem_t items[] = {{socket_.handle(), 0, ZMQ_POLLIN, 0},
                             {nullptr, wakeup_->fd(), ZMQ_POLLIN, 0},
                             {monitor_->socket().handle(), 0, ZMQ_POLLIN, 0}};
  const auto slowest = milliseconds(std::min(kSlowestTick, silence_seconds_ / 4));
  zmq::poll(items, 3, unfinished_ > 0 ? std::min(slowest, kReportStart) : slowest);
  if (items[1].revents != 0) wakeup_->clear();
}

// Unasked: what the master sends down the same connection, megabytes perhaps, must not hold up the news that
// this worker lives.
void Session::beat() {
  if (!master_listens() && state_ != State::kLoading) return;
  if (Clock::now() < next_beat_ || lost_ || done_) return;
  next_beat_ = Clock::now() + milliseconds(heartbeat_seconds_);
  proto::Envelope envelope = make_envelope(stamp_);
  envelope.mutable_heartbeat()->set_busy_slots(static_cast<std::uint32_t>(slots_->busy()));
  envelope.mutable_heartbeat()->set_queued(static_cast<std::uint32_t>(slots_->queued()));
  send(socket_, {}, envelope);
}

void Session::check_connection() {
  const ConnectionMonitor::News news = monitor_->drain();
  for (const FailedHandshake& failed : news.failed) warn_of(failed.why);
  if (news.closed.empty() || state_ == State::kGreeting) return;
  read_all();  // what came just before the end: that the run is over, perhaps
  if (done_) return;
  spdlog::warn("the connection to the master ended: connecting anew");
  lost_ = true;
}

void Session::check_silence() {
  if (lost_) return;
  // Time in which this thread did not run is not the master's silence; nor is a large message on a slow link.
  const Clock::duration absent = Clock::now() - std::exchange(looked_, Clock::now());
  if (absent > milliseconds(kAbsentSeconds)) heard_ = std::min(Clock::now(), heard_ + absent);
  const double limit = state_ == State::kGreeting
                           ? patience_ * jitter()
                           : silence_seconds_ + static_cast<double>(largest_) / kSlowestLink;
  if (Clock::now() - heard_ < milliseconds(limit)) return;
  if (state_ != State::kGreeting) spdlog::warn("the master is silent: connecting anew");
  lost_ = true;
}

void Session::give_up(Error error) {
  error_ = std::move(error);
  done_ = true;
}

// ---- what the master says ----

void Session::read_all() {
  Received message;
  while (!done_ && !lost_ && receive(socket_, false, arena_, message)) {
    heard_ = served_ = Clock::now();
    warned_of_.reset();
    alone_said_ = false;
    largest_ = std::max(largest_, message.size);
    if (message.envelope == nullptr)
      give_up({ErrorCode::kUnavailable, endpoint_ + ": sent " + message.fault});
    else
      handle(message);
    message.envelope = nullptr;
    arena_.Reset();
  }
}

void Session::handle(Received& message) {
  const proto::Envelope& envelope = *message.envelope;
  const SessionStamp stamp{envelope.run(), envelope.epoch()};
  if (envelope.has_welcome()) {
    if (state_ == State::kGreeting) on_welcome(envelope.welcome(), stamp);
    return;  // a second one would begin anew what is under way
  }
  if (envelope.has_refusal()) return on_refusal(envelope.refusal());
  if (state_ == State::kGreeting || stamp != stamp_) return;
  switch (envelope.body_case()) {
    case proto::Envelope::kAssetReply:
      return on_asset(envelope.asset_reply(), message.attachments);
    case proto::Envelope::kTask:
    case proto::Envelope::kStepRequest:
      return enqueue(message);
    case proto::Envelope::kCancel:
      return on_cancel(envelope.cancel());
    case proto::Envelope::kHeartbeat: {
      proto::Envelope answer = make_envelope(stamp_);
      answer.mutable_heartbeat()->set_sequence(envelope.heartbeat().sequence());
      answer.mutable_heartbeat()->set_busy_slots(static_cast<std::uint32_t>(slots_->busy()));
      answer.mutable_heartbeat()->set_queued(static_cast<std::uint32_t>(slots_->queued()));
      send(socket_, {}, answer);
      return;
    }
    case proto::Envelope::kDrain:
      return on_drain(envelope.drain());
    default:
      return;
  }
}

void Session::enqueue(Received& message) {
  if (state_ != State::kServing) return;
  Job job;
  job.stamp = stamp_;
  job.session = session_;
  job.envelope = *message.envelope;
  job.networks = std::move(message.attachments);
  if (job.envelope.has_task()) {
    if (Status status = memory_.complete(*job.envelope.mutable_task(), job.networks); !status) {
      spdlog::warn("{}: {}: connecting anew", endpoint_, status.error().message);
      lost_ = true;
      return;
    }
    ++unfinished_;
  }
  slots_->push(std::move(job));
}

void Session::on_cancel(const proto::Cancel& cancel) {
  if (cancel.id().empty())
    unfinished_ -= static_cast<int>(slots_->take_back().size());
  else
    unfinished_ -= slots_->cancel({cancel.id().data(), static_cast<std::size_t>(cancel.id_size())});
}

void Session::on_drain(const proto::Drain& drain) {
  spdlog::info("{} has no more work: {}", endpoint_, drain.reason());
  done_ = done_ || options_.once;
}

// ---- what the slots and the operator say ----

void Session::send_events() {
  for (const StartedTask& task : slots_->take_started(kReportStart)) {
    if (task.session != session_ || !master_listens()) continue;
    proto::Envelope envelope = make_envelope(stamp_);
    envelope.mutable_started()->set_id(task.task);
    envelope.mutable_started()->set_attempt(task.attempt);
    send(socket_, {}, envelope);
  }
  for (SlotEvent& event : slots_->take_events()) {
    if (event.session != session_ || !master_listens()) continue;
    if (event.task != 0) --unfinished_;
    next_beat_ = Clock::now() + milliseconds(heartbeat_seconds_);  // a result is news enough
    send(socket_, {}, std::move(event.frame));
  }
  take_simulator();
}

void Session::obey() {
  if (order_ == kStop) done_ = true;
  if (order_ == kDrain && state_ != State::kDraining) {
    if (state_ != State::kServing) {
      done_ = true;
    } else {
      state_ = State::kDraining;
      drain_deadline_ = Clock::now() + milliseconds(options_.drain_seconds);
      handed_back_ = slots_->take_back();
      unfinished_ -= static_cast<int>(handed_back_.size());
      spdlog::info("draining: {} to finish, {} handed back", counted(unfinished_, "task"),
                   handed_back_.size());
      proto::Envelope envelope = make_envelope(stamp_);
      envelope.mutable_drain()->set_reason("asked to");
      if (socket_) send(socket_, {}, envelope);  // none while a rendezvous names no master
      farewell_ = "drained";
    }
  }
  if (state_ == State::kDraining && drained()) done_ = true;
  if (!done_ || !connected_ || state_ == State::kGreeting) return;
  proto::Envelope envelope = make_envelope(stamp_);
  envelope.mutable_goodbye()->set_reason(farewell_.empty() ? "stopped" : farewell_);
  for (const std::uint64_t task : handed_back_) envelope.mutable_goodbye()->add_unfinished(task);
  socket_.set(zmq::sockopt::linger, 200);
  send(socket_, {}, envelope);
}

bool Session::drained() {
  if (unfinished_ <= 0) return true;
  if (Clock::now() < drain_deadline_) return false;
  error_ = Error{ErrorCode::kUnavailable, "a slot did not finish in time: its task goes back to the master"};
  return true;
}

}  // namespace evograsp::worker

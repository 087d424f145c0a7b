// From a Welcome to a simulator.
#include <utility>

#include "common/counted.h"
#include "common/log.h"
#include "worker/calibration.h"
#include "worker/session.h"

namespace evograsp::worker {

namespace {

// The nearest value between the two; the first for what is no number.
double within(double value, double least, double most) {
  return value >= least ? std::min(value, most) : least;
}

}  // namespace

struct Session::Built {
  std::uint64_t session = 0;
  std::atomic<bool> ready{false};
  Result<std::shared_ptr<const sim::Simulator>> simulator{nullptr};
  double trial_seconds = 0;
};

void Session::on_welcome(const proto::Welcome& welcome, const SessionStamp& stamp) {
  stamp_ = stamp;
  silence_seconds_ = within(welcome.silence_seconds(), 0.05, 3600);
  heartbeat_seconds_ = within(welcome.heartbeat_seconds(), 0.01, 3600);
  patience_ = kFirstPatience;
  spdlog::info("welcome to {}: {}", endpoint_, counted(options_.slots, "slot"));
  if (welcome.experiment().object_id().empty()) {  // no-op work only
    fingerprint_.clear();
    slots_->set_simulator(nullptr);
    return announce_ready(welcome.experiment().fingerprint());
  }
  if (!fingerprint_.empty() && fingerprint_ == welcome.experiment().fingerprint())
    return announce_ready(fingerprint_);
  state_ = State::kLoading;
  if (Status status = loader_.begin(welcome.experiment()); !status) {
    farewell_ = status.error().message;
    return give_up(status.error());
  }
  request_assets();
}

void Session::on_refusal(const proto::Refusal& refusal) {
  if (!refusal.retry())
    return give_up({ErrorCode::kUnavailable, endpoint_ + " refuses: " + refusal.reason()});
  spdlog::warn("{} refuses for now: {}", endpoint_, refusal.reason());
  lost_ = true;
}

void Session::request_assets() {
  const std::vector<std::string> missing = loader_.missing();
  if (missing.empty()) return build_simulator();
  for (const std::string& id : missing) {
    proto::Envelope envelope = make_envelope(stamp_);
    envelope.mutable_asset_request()->set_id(id);
    send(socket_, {}, envelope);
  }
}

void Session::on_asset(const proto::AssetReply& reply, const std::vector<zmq::message_t>& attachments) {
  if (state_ != State::kLoading || built_) return;
  if (!reply.found() || attachments.size() != 1)
    return give_up({ErrorCode::kNotFound, endpoint_ + " does not have asset " + reply.id()});
  const Status status = loader_.accept(reply.id(), attachments[0].to_string_view());
  if (!status) return give_up({status.error().code, endpoint_ + ": " + status.error().message});
  if (loader_.missing().empty()) build_simulator();
}

// On a slot: heartbeats go on meanwhile.
void Session::build_simulator() {
  built_ = std::make_shared<Built>();
  Job job;
  job.errand = [built = built_, loader = loader_, wakeup = wakeup_] {
    try {
      built->simulator = loader.build();
      if (built->simulator) built->trial_seconds = measure_grasp(**built->simulator);
    } catch (const std::exception& error) {  // not enough memory, mostly
      built->simulator =
          fail(ErrorCode::kInvalid, std::string("the experiment cannot be held here: ") + error.what());
    }
    built->ready = true;
    wakeup->notify();
  };
  slots_->push(std::move(job));
}

void Session::announce_ready(const std::string& fingerprint) {
  state_ = State::kServing;
  proto::Envelope envelope = make_envelope(stamp_);
  envelope.mutable_ready()->set_fingerprint(fingerprint);
  if (trial_seconds_ > 0) envelope.mutable_ready()->set_trial_seconds(trial_seconds_);
  send(socket_, {}, envelope);
}

void Session::take_simulator() {
  if (!built_ || !built_->ready) return;
  const auto built = std::exchange(built_, nullptr);
  if (!built->simulator) {
    farewell_ = built->simulator.error().message;
    return give_up(built->simulator.error());
  }
  auto shared = std::make_shared<SharedSimulator>();
  shared->simulator = *built->simulator;
  slots_->set_simulator(std::move(shared));
  fingerprint_ = loader_.experiment().fingerprint();
  trial_seconds_ = built->trial_seconds;
  announce_ready(fingerprint_);
}

}  // namespace evograsp::worker

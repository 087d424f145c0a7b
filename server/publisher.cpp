#include "server/publisher.h"

#include "common/digest.h"

namespace evograsp::server {

namespace {

constexpr int kMostWaiting = 8;  // champions, for each robot that does not read: it wants the newest anyhow
// bytes. libzmq keeps what is subscribed to in a tree with a branch a byte and takes that down by recursion:
// a topic of some hundred thousand ends the process. The handshake's frames are smaller, too.
constexpr std::int64_t kLargestSubscription = 1024;
// bytes that a robot may send: subscriptions are kept as long as it stays. Heartbeats of a week.
constexpr std::uint64_t kMostSaid = std::uint64_t{2} << 20;

}  // namespace

Status Publisher::open(zmq::context_t& context, const proto::NetConfig& net, const Security& security,
                       std::shared_ptr<Strangers> strangers) {
  if (!net.has_publish() || net.publish().empty()) return {};
  if (Status status = check_exposure(net.publish(), security.encrypted(), net.insecure()); !status)
    return status;
  SocketOptions options = security.socket_options(net);
  options.high_water = kMostWaiting;
  options.max_frame_bytes = kLargestSubscription;
  auto socket = make_publisher(context, options);
  if (!socket) return tl::unexpected(socket.error());
  socket_ = std::move(*socket);
  monitor_ = std::make_unique<ConnectionMonitor>(context, socket_);
  auto bound = bind(socket_, net.publish());
  if (!bound) return tl::unexpected(bound.error());
  endpoint_ = std::move(*bound);
  strangers_ = std::move(strangers);
  return {};
}

void Publisher::publish(const ResumePoint& run, const RunPosition& position) {
  if (!socket_ || !position.best) return;
  if (sent_ && position.best->generation == sent_generation_) return;
  const auto champion = make_champion(run.info.config, run.info.experiment.fingerprint(), *position.best, {});
  if (!champion) return;
  publish(*champion);
  sent_ = true;
  sent_generation_ = position.best->generation;
}

void Publisher::look_at_door() {
  if (!monitor_) return;
  for (const std::string& address : monitor_->end_floods(kMostSaid))
    strangers_->tell(Offence::kFlood, address, "at the champion port: subscribes to too much");
  for (const FailedHandshake& failed : monitor_->drain().failed)
    strangers_->tell(Offence::kHandshake, failed.address,
                     std::string("at the champion port: ") + to_string(failed.why));
}

void Publisher::publish(const proto::Champion& champion) {
  if (!socket_) return;
  socket_.send(zmq::str_buffer("champion"), zmq::send_flags::sndmore | zmq::send_flags::dontwait);
  socket_.send(zmq::buffer(deterministic_bytes(champion)), zmq::send_flags::dontwait);
}

}  // namespace evograsp::server

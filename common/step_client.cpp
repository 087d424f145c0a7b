#include "common/step_client.h"

#include <unistd.h>

#include <utility>

#include "common/version.h"

namespace evograsp {

Result<StepClient> StepClient::connect(const std::string& endpoint, const std::optional<CurveKeys>& keys,
                                       double seconds) {
  StepClient client;
  client.endpoint_ = endpoint;
  SocketOptions options;
  options.curve = keys;
  auto socket = make_dealer(*client.context_, endpoint, options);
  if (!socket) return tl::unexpected(socket.error());
  client.socket_ = std::move(*socket);
  proto::Envelope hello = make_envelope({});
  hello.mutable_hello()->set_build(kVersion);
  hello.mutable_hello()->set_identity("step-client");
  hello.mutable_hello()->set_pid(static_cast<std::uint32_t>(getpid()));
  hello.mutable_hello()->set_stepwise(true);
  send(client.socket_, {}, hello);
  auto welcome = client.next(after(seconds));
  if (!welcome) return tl::unexpected(welcome.error());
  const proto::Envelope& envelope = welcome->envelope;
  if (!envelope.has_welcome())
    return fail(ErrorCode::kUnavailable, endpoint + ": answers hello with something else");
  client.stamp_ = {envelope.run(), envelope.epoch()};
  client.experiment_ = envelope.welcome().experiment();
  return client;
}

Result<proto::StepReply> StepClient::ask(proto::StepRequest request, double seconds) {
  request.set_id(++last_id_);
  proto::Envelope envelope = make_envelope(stamp_);
  *envelope.mutable_step_request() = std::move(request);
  send(socket_, {}, envelope);
  const auto end = after(seconds);  // whatever else comes meanwhile
  for (;;) {
    auto answer = next(end);
    if (!answer) return tl::unexpected(answer.error());
    const proto::StepReply& reply = answer->envelope.step_reply();
    if (!answer->envelope.has_step_reply() || reply.id() != last_id_) continue;
    if (reply.has_error()) return fail(ErrorCode::kInvalid, endpoint_ + ": " + reply.error());
    return reply;
  }
}

Result<std::string> StepClient::asset(const std::string& id, double seconds) {
  proto::Envelope envelope = make_envelope(stamp_);
  envelope.mutable_asset_request()->set_id(id);
  send(socket_, {}, envelope);
  const auto end = after(seconds);
  for (;;) {
    auto answer = next(end);
    if (!answer) return tl::unexpected(answer.error());
    const proto::AssetReply& reply = answer->envelope.asset_reply();
    if (!answer->envelope.has_asset_reply() || reply.id() != id) continue;
    if (!reply.found() || answer->attachments.size() != 1)
      return fail(ErrorCode::kNotFound, endpoint_ + ": does not have asset " + id);
    return answer->attachments[0].to_string();
  }
}

StepClient::Clock::time_point StepClient::after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

Result<StepClient::Answer> StepClient::next(Clock::time_point end) {
  while (Clock::now() < end) {
    zmq::pollitem_t item{socket_.handle(), 0, ZMQ_POLLIN, 0};
    zmq::poll(&item, 1, std::chrono::milliseconds(20));
    google::protobuf::Arena arena;
    Received received;
    if (!receive(socket_, false, arena, received)) continue;
    if (received.envelope == nullptr)
      return fail(ErrorCode::kInvalid, endpoint_ + ": sent " + received.fault);
    if (received.envelope->has_refusal())
      return fail(ErrorCode::kUnavailable, endpoint_ + " refuses: " + received.envelope->refusal().reason());
    return Answer{*received.envelope, std::move(received.attachments)};
  }
  return fail(ErrorCode::kUnavailable, endpoint_ + ": no answer");
}

}  // namespace evograsp

// Stepwise clients: each command goes to a slot of some worker, with what the master remembers of the client,
// and the answer comes back the same way.
#include <algorithm>
#include <utility>

#include "common/version.h"
#include "server/dispatch_loop.h"

namespace evograsp::server {

namespace {

constexpr std::size_t kMostClients = 256;
constexpr double kIdleSeconds = 600;  // a client that said nothing for so long must say hello again

}  // namespace

void DispatchLoop::on_client_hello(const Received& message) {
  if (message.envelope->hello().build() != kVersion)
    return refuse(message.peer, std::string("the master is version ") + kVersion + ": use the same", false);
  if (clients_.size() >= kMostClients) return refuse(message.peer, "too many stepwise clients", true);
  Client& client = clients_[message.peer];
  client = {};
  client.id = next_client_++;
  client.heard = now();
  welcome(message.peer);
}

void DispatchLoop::on_step_request(const std::string& peer, Client& client, proto::StepRequest request) {
  client.heard = now();
  if (client.worker != 0) return step_error(peer, request.id(), "one command at a time");
  Session* chosen = nullptr;
  for (const auto& [id, session] : by_id_) {
    const bool able = session->ready && session->view.state == "active" && scheduler_.slots(id) > 0;
    if (able && (chosen == nullptr || scheduler_.outstanding(id) < scheduler_.outstanding(chosen->id)))
      chosen = session;
  }
  if (chosen == nullptr) return refuse(peer, "no worker is connected: start one, then ask again", true);
  if (request.has_shuffle()) client.seed = request.shuffle().seed();
  if (request.has_get_info()) client.target = request.get_info().target();
  request.set_client(client.id);
  request.set_target(client.target);
  request.clear_seed();
  if (client.seed) request.set_seed(*client.seed);
  client.pending = request.id();
  client.worker = chosen->id;
  proto::Envelope envelope = make_envelope(options_.stamp);
  *envelope.mutable_step_request() = std::move(request);
  if (send(router_, chosen->peer, envelope) == SendResult::kSent) return;
  client.worker = 0;
  refuse(peer, "the worker cannot be reached: ask again", true);
}

void DispatchLoop::on_step_reply(const Session& session, proto::StepReply reply) {
  const auto client = std::find_if(clients_.begin(), clients_.end(), [&](const auto& entry) {
    return entry.second.id == reply.client() && entry.second.worker == session.id;
  });
  if (client == clients_.end()) return;
  client->second.worker = 0;
  reply.clear_client();
  proto::Envelope envelope = make_envelope(options_.stamp);
  *envelope.mutable_step_reply() = std::move(reply);
  send(router_, client->first, envelope);
}

void DispatchLoop::step_error(const std::string& peer, std::uint64_t id, const std::string& error) {
  proto::Envelope envelope = make_envelope(options_.stamp);
  envelope.mutable_step_reply()->set_id(id);
  envelope.mutable_step_reply()->set_error(error);
  send(router_, peer, envelope);
}

void DispatchLoop::fail_steps_of(WorkerId worker) {
  for (auto& [peer, client] : clients_) {
    if (client.worker != worker) continue;
    client.worker = 0;
    refuse(peer, "the worker went away: ask again", true);
  }
}

void DispatchLoop::forget_idle_clients() {
  std::erase_if(clients_, [&](const auto& entry) { return entry.second.heard < now() - kIdleSeconds; });
}

}  // namespace evograsp::server

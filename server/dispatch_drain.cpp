// Workers that an operator takes out of the run, and back in.
#include "server/dispatch_loop.h"

namespace evograsp::server {

void DispatchLoop::set_drained(const std::string& node, bool drained) {
  if (drained)
    drained_.insert(node);
  else
    drained_.erase(node);
  sink_.event(false, drained ? "drained" : "undrained",
              node + (drained ? ": its workers get no more work" : ": its workers get work again"));
  for (const auto& [id, session] : by_id_) follow_drain(*session);
  pump_all();
}

// What a drained worker holds it finishes; a worker that is leaving by itself stays on its way.
void DispatchLoop::follow_drain(Session& session) {
  const bool held = drained_.contains(session.view.host) || drained_.contains(session.view.identity);
  if (held == session.held || session.leaving) return;
  session.held = held;
  session.view.state = held ? "draining" : "active";
  scheduler_.set_active(session.id, session.ready && !held);
  sink_.worker(session.view);
}

}  // namespace evograsp::server

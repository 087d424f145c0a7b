#include "server/security.h"

#include <algorithm>

#include "common/log.h"
#include "common/wire.h"

namespace evograsp::server {

namespace {

// Times the silence that the dispatcher tolerates: see SocketOptions::silence_seconds.
constexpr double kTransportPatience = 4;

}  // namespace

Status Security::open(zmq::context_t& context, const proto::NetConfig& net, DispatcherOptions& options) {
  std::optional<std::set<std::string>> listed;  // none: whoever can reach the port
  if (!net.curve_secret_key_file().empty()) {
    auto keys = load_keys(net.curve_secret_key_file());
    if (!keys) return tl::unexpected(keys.error());
    auto allowed = load_allow_list(net.curve_allow_file());
    if (!allowed) return tl::unexpected(allowed.error());
    keys_ = std::move(*keys);
    listed = std::move(*allowed);
  }
  auto gatekeeper = Gatekeeper::create(context, std::move(listed), options.strangers);
  if (!gatekeeper) return tl::unexpected(gatekeeper.error());
  gatekeeper_ = std::move(*gatekeeper);
  for (const std::string& endpoint : options.endpoints)
    if (Status status = check_exposure(endpoint, encrypted(), net.insecure()); !status) return status;
  if (!net.listen().empty() && !is_loopback(net.listen()) && !encrypted())
    spdlog::warn("insecure: {} takes any worker and encrypts nothing", net.listen());
  options.socket = socket_options(net);
  return {};
}

SocketOptions Security::socket_options(const proto::NetConfig& net) const {
  SocketOptions options;
  options.max_frame_bytes =
      std::min<std::int64_t>(net.max_frame_bytes(), static_cast<std::int64_t>(kMaxEnvelopeToMaster));
  options.silence_seconds = kTransportPatience * net.silence_seconds();
  options.curve = keys_;
  options.gatekept = true;
  return options;
}

}  // namespace evograsp::server

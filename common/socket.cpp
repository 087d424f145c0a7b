#include "common/socket.h"

#include <arpa/inet.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

namespace evograsp {

namespace {

// What a firewall or a sleeping peer may hold back before ZeroMQ looks dead: milliseconds of a duration.
int milliseconds(double seconds) {
  return static_cast<int>(seconds * 1000);
}

void apply(zmq::socket_t& socket, const SocketOptions& options) {
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::maxmsgsize, options.max_frame_bytes);
  socket.set(zmq::sockopt::sndhwm, options.high_water);
  socket.set(zmq::sockopt::rcvhwm, options.high_water);
  const int third = std::max(1, static_cast<int>(options.silence_seconds / 3));
  socket.set(zmq::sockopt::tcp_keepalive, 1);
  socket.set(zmq::sockopt::tcp_keepalive_idle, third);
  socket.set(zmq::sockopt::tcp_keepalive_intvl, third);
  socket.set(zmq::sockopt::tcp_keepalive_cnt, 2);
  socket.set(zmq::sockopt::tcp_maxrt, milliseconds(options.silence_seconds));
  // A peer that connects and says nothing holds a descriptor this long and no longer.
  socket.set(zmq::sockopt::handshake_ivl, 5000);
}

void apply_keys(zmq::socket_t& socket, const CurveKeys& keys) {
  socket.set(zmq::sockopt::curve_publickey, keys.public_key);
  socket.set(zmq::sockopt::curve_secretkey, keys.secret_key);
}

tl::unexpected<Error> socket_error(const std::string& endpoint, const char* what, const zmq::error_t& error) {
  const ErrorCode code = error.num() == EINVAL ? ErrorCode::kUsage : ErrorCode::kUnavailable;
  return fail(code, endpoint + ": cannot " + what + ": " + error.what());
}

}  // namespace

bool is_loopback(const std::string& endpoint) {
  const auto starts_with = [&](std::string_view prefix) { return endpoint.rfind(prefix, 0) == 0; };
  return starts_with("inproc://") || starts_with("ipc://") || starts_with("tcp://127.") ||
         starts_with("tcp://localhost:") || starts_with("tcp://[::1]:");
}

Status check_exposure(const std::string& endpoint, bool encrypted, bool insecure) {
  if (is_loopback(endpoint) || encrypted || insecure) return {};
  return fail(
      ErrorCode::kUsage,
      endpoint +
          ": refusing to listen beyond this machine without keys; make them with `evograsp keygen` and "
          "set net.curve_secret_key_file and net.curve_allow_file, or spell out --insecure");
}

namespace {

Result<zmq::socket_t> make_server(zmq::context_t& context, zmq::socket_type type,
                                  const SocketOptions& options) {
  try {
    zmq::socket_t socket(context, type);
    apply(socket, options);
    socket.set(zmq::sockopt::rcvhwm, 0);
    socket.set(zmq::sockopt::backlog, 4096);
    if (options.curve) {
      apply_keys(socket, *options.curve);
      socket.set(zmq::sockopt::curve_server, true);
    }
    if (options.curve || options.gatekept) socket.set(zmq::sockopt::zap_domain, "evograsp");
    if (type == zmq::socket_type::router) socket.set(zmq::sockopt::router_mandatory, true);
    return socket;
  } catch (const zmq::error_t& error) {
    return socket_error("listening", "make a socket", error);
  }
}

}  // namespace

Result<zmq::socket_t> make_router(zmq::context_t& context, const SocketOptions& options) {
  return make_server(context, zmq::socket_type::router, options);
}

Result<zmq::socket_t> make_publisher(zmq::context_t& context, const SocketOptions& options) {
  return make_server(context, zmq::socket_type::pub, options);
}

Result<std::string> bind(zmq::socket_t& socket, const std::string& endpoint) {
  try {
    socket.bind(endpoint);
    return socket.get(zmq::sockopt::last_endpoint);
  } catch (const zmq::error_t& error) {
    return socket_error(endpoint, "listen", error);
  }
}

Result<zmq::socket_t> make_dealer(zmq::context_t& context, const std::string& endpoint,
                                  const SocketOptions& options) {
  try {
    zmq::socket_t socket(context, zmq::socket_type::dealer);
    apply(socket, options);
    socket.set(zmq::sockopt::reconnect_ivl, 50);
    socket.set(zmq::sockopt::reconnect_ivl_max, 500);
    if (options.curve) {
      apply_keys(socket, *options.curve);
      socket.set(zmq::sockopt::curve_serverkey, options.curve->server_key);
    }
    socket.connect(endpoint);
    return socket;
  } catch (const zmq::error_t& error) {
    return socket_error(endpoint, "connect", error);
  }
}

std::string peer_address(int descriptor) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return {};
  char text[INET6_ADDRSTRLEN] = {};
  if (peer.ss_family == AF_INET)
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in&>(peer).sin_addr, text, sizeof text);
  else if (peer.ss_family == AF_INET6)
    inet_ntop(AF_INET6, &reinterpret_cast<const sockaddr_in6&>(peer).sin6_addr, text, sizeof text);
  return text;
}

Wakeup::Wakeup() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}
Wakeup::~Wakeup() {
  if (fd_ >= 0) close(fd_);
}

void Wakeup::notify() noexcept {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(fd_, &one, sizeof one);
}

void Wakeup::clear() noexcept {
  std::uint64_t count;
  [[maybe_unused]] const ssize_t got = read(fd_, &count, sizeof count);
}

}  // namespace evograsp

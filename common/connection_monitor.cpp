#include "common/connection_monitor.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cstring>

#include "common/socket.h"

namespace evograsp {

namespace {

using Why = FailedHandshake::Why;

constexpr int kEvents = ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                        ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                        ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;

Why why_of(std::int32_t protocol_error) {
  switch (protocol_error) {
    case ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH:
      return Why::kMechanism;
    case ZMQ_PROTOCOL_ERROR_ZMTP_CRYPTOGRAPHIC:
    case ZMQ_PROTOCOL_ERROR_ZMTP_KEY_EXCHANGE:
      return Why::kKeys;
    default:
      return Why::kProtocol;
  }
}

}  // namespace

const char* to_string(FailedHandshake::Why why) {
  switch (why) {
    case Why::kNoGreeting:
      return "speaks no ZMTP 3 (HTTP? a scanner?)";
    case Why::kGone:
      return "hung up or fell silent during the handshake";
    case Why::kMechanism:
      return "one side has keys (CURVE), the other has none";
    case Why::kKeys:
      return "CURVE with another master's public key";
    case Why::kNotListed:
      return "a key that is not on the allow-list";
    case Why::kProtocol:
      break;
  }
  return "breaks ZMTP during the handshake";
}

ConnectionMonitor::ConnectionMonitor(zmq::context_t& context, zmq::socket_t& watched)
    : watched_(watched), events_(context, zmq::socket_type::pair) {
  // Never a name twice: libzmq gives one free some time after its socket is closed.
  static std::atomic<std::uint64_t> count{0};
  const std::string name = "inproc://monitor-" + std::to_string(++count);
  if (zmq_socket_monitor(watched.handle(), name.c_str(), kEvents) != 0) throw zmq::error_t();
  events_.set(zmq::sockopt::linger, 0);
  events_.set(zmq::sockopt::rcvhwm, 0);
  events_.connect(name);
}

ConnectionMonitor::~ConnectionMonitor() {
  zmq_socket_monitor(watched_.handle(), nullptr, 0);
}

ConnectionMonitor::News ConnectionMonitor::drain() {
  News news;
  for (;;) {
    const bool some = read_waiting(news);
    believe_addresses();
    if (!some) return news;
    ask_addresses();
  }
}

// False when nothing was waiting.
bool ConnectionMonitor::read_waiting(News& news) {
  zmq::message_t event, address;
  bool some = false;
  while (events_.recv(event, zmq::recv_flags::dontwait)) {
    some = true;
    if (event.more() && !events_.recv(address)) break;
    if (event.size() != 6) continue;
    std::uint16_t kind;
    std::int32_t value;
    std::memcpy(&kind, event.data(), sizeof kind);
    std::memcpy(&value, static_cast<const char*>(event.data()) + sizeof kind, sizeof value);
    handle(kind, value, news);
  }
  return some;
}

void ConnectionMonitor::handle(std::uint16_t kind, std::int32_t value, News& news) {
  switch (kind) {
    case ZMQ_EVENT_ACCEPTED:
      bound_ = true;
      callers_[value] = {};
      read_[value] = 0;
      unasked_.push_back(value);
      return;
    case ZMQ_EVENT_HANDSHAKE_SUCCEEDED:
      return succeeded();
    case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH:
      // A connecting socket is told by its server. A bound one has asked its gatekeeper, who knows more, and
      // ends the connection some other time.
      if (bound_) return succeeded();
      has_failed_ = true;
      why_ = Why::kNotListed;
      return;
    case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
      has_failed_ = true;
      why_ = why_of(value);
      return;
    case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
      has_failed_ = true;
      why_ = Why::kGone;
      return;
    case ZMQ_EVENT_DISCONNECTED:
      return ended(value, news);
    default:
      return;
  }
}

void ConnectionMonitor::succeeded() {
  if (callers_.size() == 1)
    callers_.clear();
  else
    through_ = std::min(through_ + 1, callers_.size());
}

void ConnectionMonitor::spoke(int descriptor) {
  if (callers_.erase(descriptor) == 0) return;
  if (through_ > 0) --through_;
}

void ConnectionMonitor::read(int descriptor, std::size_t bytes) {
  const auto connection = read_.find(descriptor);
  if (connection != read_.end()) connection->second += bytes;
}

// A descriptor that libzmq has closed since the last drain() may be somebody else's by now: with bad luck, a
// peer too many must connect anew.
std::vector<std::string> ConnectionMonitor::end_floods(std::uint64_t most) {
  std::vector<std::string> ended;
  for (auto& [descriptor, bytes] : read_) {
    tcp_info info{};
    socklen_t size = sizeof info;
    if (getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) continue;
    if (info.tcpi_bytes_received < bytes + most) continue;
    ended.push_back(peer_address(descriptor));
    const linger at_once{1, 0};  // or the peer's last bytes are waited for
    setsockopt(descriptor, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    shutdown(descriptor, SHUT_RDWR);
    bytes = info.tcpi_bytes_received;  // once
  }
  return ended;
}

void ConnectionMonitor::ended(int descriptor, News& news) {
  news.closed.push_back(descriptor);
  read_.erase(descriptor);
  const auto caller = callers_.find(descriptor);
  const bool known = caller != callers_.end();
  std::string address = known && caller->second.sure ? caller->second.address : std::string();
  if (known) callers_.erase(caller);
  if (has_failed_) {
    has_failed_ = false;
    news.failed.push_back({why_, std::move(address)});
  } else if (known && through_ > 0) {
    --through_;  // in doubt, it had been one of these
  } else if (known) {
    news.failed.push_back({Why::kNoGreeting, std::move(address)});
  }
  through_ = std::min(through_, callers_.size());
}

// Whose end had not been announced after they were asked: libzmq announces it before it closes the
// descriptor.
void ConnectionMonitor::believe_addresses() {
  for (const int descriptor : unsure_)
    if (const auto caller = callers_.find(descriptor); caller != callers_.end())
      caller->second.sure = caller->second.asked;
  unsure_.clear();
}

void ConnectionMonitor::ask_addresses() {
  for (const int descriptor : unasked_) {
    const auto caller = callers_.find(descriptor);
    if (caller == callers_.end() || caller->second.asked) continue;
    caller->second.address = peer_address(descriptor);
    caller->second.asked = true;
    unsure_.push_back(descriptor);
  }
  unasked_.clear();
}

}  // namespace evograsp

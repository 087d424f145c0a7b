// Faults that strangers make at the master's doors, and insiders that say the wrong thing.
#include <sys/socket.h>

#include <cstdlib>
#include <cstring>

#include "common/connection_monitor.h"
#include "common/version.h"
#include "common/wire.h"
#include "common/zap.h"
#include "tests/server/raw_connection.h"
#include "tests/soak/soak_run.h"

namespace evograsp::soak {

using testing::raw_connection;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::size_t kTooLarge = 5 << 20;  // a master takes envelopes of 4 MiB
constexpr std::size_t kLeastSession = 200;  // bytes: a greeting and a hello
constexpr std::size_t kMostHeld = 200;

// What comes back within `seconds`: a message that is no heartbeat.
std::optional<proto::Envelope> answer(zmq::socket_t& socket, double seconds) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  google::protobuf::Arena arena;
  while (Clock::now() < end) {
    zmq::pollitem_t item{socket.handle(), 0, ZMQ_POLLIN, 0};
    zmq::poll(&item, 1, std::chrono::milliseconds(10));
    Received received;
    if (receive(socket, false, arena, received) && received.envelope != nullptr &&
        !received.envelope->has_heartbeat())
      return *received.envelope;
  }
  return std::nullopt;
}

proto::Envelope hello_of(const std::string& identity) {
  proto::Envelope envelope = make_envelope({});
  proto::Hello& hello = *envelope.mutable_hello();
  hello.set_build(kVersion);
  hello.set_host("elsewhere");
  hello.set_pid(1);
  hello.set_slots(1);
  hello.set_identity(identity);
  return envelope;
}

bool send_all(int fd, const std::string& bytes) {
  const timeval patience{1, 0};
  setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  return ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

}  // namespace

// With a key that opens, where keys are wanted.
SocketOptions SoakRun::insider() const {
  SocketOptions options;
  if (conditions_.keys) options.curve = *load_keys(folder_ / "worker.key");
  return options;
}

// ---- at the workers' door ----

bool SoakRun::other_protocol() {
  zmq::context_t context(1);
  auto socket = std::move(*make_dealer(context, endpoint_, insider()));
  proto::Envelope envelope = make_envelope({});
  envelope.set_protocol(kProtocolVersion + 1);
  envelope.mutable_hello()->set_identity("from-tomorrow");
  send(socket, {}, envelope);
  const auto said = answer(socket, 1);
  if (said && said->has_welcome()) return complain("another protocol version was welcomed");
  return said && said->has_refusal();
}

bool SoakRun::garbage() {
  const int fd = raw_connection(endpoint_);
  if (fd < 0) return false;
  std::string bytes(20000, '\0');
  for (char& b : bytes) b = static_cast<char>(random_.next());
  const bool sent = send_all(fd, bytes);
  close(fd);
  return sent;
}

bool SoakRun::half_open() {
  for (const int fd : held_open_) close(fd);
  held_open_.clear();
  for (int i = 0; i < 50; ++i)
    if (const int fd = raw_connection(endpoint_); fd >= 0) held_open_.push_back(fd);
  return held_open_.size() == 50;
}

bool SoakRun::tiny_frames() {
  zmq::context_t context(1);
  auto socket = std::move(*make_dealer(context, endpoint_, insider()));
  const auto end = Clock::now() + std::chrono::milliseconds(300);
  std::uint64_t sent = 0;
  while (Clock::now() < end)
    if (socket.send(zmq::buffer("x", 1), zmq::send_flags::dontwait)) ++sent;
  return sent > 1000 && answer(socket, 1).has_value();
}

bool SoakRun::oversized_frame() {
  zmq::context_t context(1);
  auto socket = std::move(*make_dealer(context, endpoint_, insider()));
  ConnectionMonitor monitor(context, socket);
  socket.send(zmq::buffer(std::string(kTooLarge, 'x')), zmq::send_flags::dontwait);
  return wait_for([&] { return !monitor.drain().closed.empty(); }, 1.5);
}

// All that the first worker ever said on its last connection, by somebody else, again.
bool SoakRun::replayed_bytes() {
  const std::string bytes = relay_->recorded();
  if (bytes.size() < kLeastSession) return false;
  const int fd = raw_connection(endpoint_);
  if (fd < 0) return false;
  const bool sent = send_all(fd, bytes);
  std::this_thread::sleep_for(std::chrono::milliseconds(random_.below(400)));
  close(fd);
  return sent;
}

// True when the master was there and did not answer.
bool SoakRun::knock(const SocketOptions& options) {
  const auto listens = [&] {
    const int fd = raw_connection(endpoint_);
    if (fd >= 0) close(fd);
    return fd >= 0;
  };
  if (!listens()) return false;
  zmq::context_t context(1);
  auto socket = std::move(*make_dealer(context, endpoint_, options));
  send(socket, {}, hello_of("burglar"));
  if (answer(socket, 0.5)) return complain("a master with keys answered a stranger");
  return listens();
}

bool SoakRun::wrong_key() {
  if (!conditions_.keys) return false;
  SocketOptions options;
  options.curve = *load_keys(folder_ / "enemy.key");
  return knock(options);
}

bool SoakRun::no_key() {
  return conditions_.keys && knock({});
}

// ---- at the HTTP door ----

// The status of the answer; 0 without one.
int SoakRun::http(const std::string& request, std::string* body) {
  const int fd = raw_connection(http_endpoint_);
  if (fd < 0) return 0;
  const timeval patience{5, 0};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::string text;
  char buffer[4096];
  if (send_all(fd,
               request + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"))
    for (ssize_t got = 0; (got = recv(fd, buffer, sizeof buffer, 0)) > 0;)
      text.append(buffer, static_cast<std::size_t>(got));
  close(fd);
  if (body != nullptr) *body = text;
  return text.rfind("HTTP/1.1 ", 0) == 0 ? std::atoi(text.c_str() + std::strlen("HTTP/1.1 ")) : 0;
}

// Requests that go on for ever hold up nobody else's.
bool SoakRun::http_dawdler() {
  if (http("GET /api/v1/run") != 200) return false;  // not there yet
  if (held_open_.size() > kMostHeld) return false;
  for (int i = 0; i < 20; ++i) {
    const int fd = raw_connection(http_endpoint_);
    if (fd < 0) return false;
    send_all(fd, "GET /api/v1/run HTTP/1.1\r\nHost: loc");
    held_open_.push_back(fd);
  }
  if (http("GET /api/v1/run") == 200) return true;
  if (wait_for([&] { return server_->ended(); }, 3)) return false;  // it was just ending
  return complain("twenty unfinished requests hold up a whole one");
}

bool SoakRun::http_without_token() {
  for (const char* what : {"stop", "pause", "checkpoint"}) {
    const int status = http(std::string("POST /api/v1/") + what);
    if (status == 0) return false;
    if (status != 401) return complain(std::string(what) + " without a token: " + std::to_string(status));
  }
  return true;
}

bool SoakRun::http_path_tricks() {
  for (const char* path : {"/../../../../etc/passwd", "/api/v1/../../run.db", "/%2e%2e/%2e%2e/etc/passwd",
                           "/..%2f..%2frun.db", "//etc/passwd", "/run.db", "/api/v1/run/../../../run.db"}) {
    std::string body;
    const int status = http(std::string("GET ") + path, &body);
    if (status == 0) return false;
    if (status < 400 || status >= 500 || body.find("root:") != std::string::npos)
      return complain(std::string(path) + ": " + std::to_string(status));
  }
  return true;
}

}  // namespace evograsp::soak

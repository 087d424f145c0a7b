#include "server/api_http.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <charconv>

#include "common/socket.h"

namespace evograsp::server {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kGlance{50};   // how often a waiting thread looks whether others wait
constexpr milliseconds kLinger{200};  // for the peer to take the answer before the connection goes
constexpr int kBacklog = 256;
constexpr std::size_t kLingerBytes = 64 * 1024;

thread_local bool refusing_now = false;

// One connection's bytes, with the deadlines of HttpLimits.
class PatientStream final : public httplib::Stream {
 public:
  PatientStream(socket_t socket, const HttpLimits& limits, const std::atomic<int>& crowd)
      : socket_(socket), limits_(limits), crowd_(crowd), start_(Clock::now()) {}

  bool is_readable() const override { return wait(POLLIN, limits_.request, start_); }
  bool is_writable() const override { return wait(POLLOUT, limits_.response, write_start()); }

  ssize_t read(char* data, size_t size) override {
    // The library reads byte by byte; the socket is read in pieces.
    if (next_ == buffer_.size() && !fill()) return -1;
    const std::size_t count = std::min(size, buffer_.size() - next_);
    std::copy_n(buffer_.data() + next_, count, data);
    next_ += count;
    return static_cast<ssize_t>(count);
  }

  ssize_t write(const char* data, size_t size) override {
    if (!wait(POLLOUT, limits_.response, write_start())) return -1;
    return ::send(socket_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  void get_remote_ip_and_port(std::string& address, int& port) const override {
    address = peer_address(socket_);
    port = 0;
  }
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return socket_; }
  bool begun() const { return taken_ > 0; }

 private:
  bool fill() {
    if (taken_ >= limits_.request_bytes || !wait(POLLIN, limits_.request, start_)) return false;
    buffer_.resize(std::min<std::size_t>(4096, limits_.request_bytes - taken_));
    next_ = 0;
    const ssize_t got = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    buffer_.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    taken_ += buffer_.size();
    return got > 0;
  }

  Clock::time_point write_start() const {
    if (write_start_ == Clock::time_point()) write_start_ = Clock::now();
    return write_start_;
  }

  bool wait(short event, milliseconds patience, Clock::time_point since) const {
    for (;;) {
      pollfd ready{socket_, event, 0};
      const int found = ::poll(&ready, 1, static_cast<int>(kGlance.count()));
      if (found > 0) return (ready.revents & (event | POLLHUP)) != 0;
      if (found < 0 && errno != EINTR) return false;
      const milliseconds limit = crowd_.load(std::memory_order_relaxed) > 0 ? limits_.crowded : patience;
      if (Clock::now() - since > limit) return false;
    }
  }

  const socket_t socket_;
  const HttpLimits& limits_;
  const std::atomic<int>& crowd_;
  const Clock::time_point start_;
  mutable Clock::time_point write_start_;
  std::string buffer_;
  std::size_t next_ = 0, taken_ = 0;
};

// Closing with unread bytes makes the kernel send a reset, which can overtake the answer.
void linger_and_close(socket_t socket) {
  ::shutdown(socket, SHUT_WR);
  const Clock::time_point end = Clock::now() + kLinger;
  char sink[4096];
  std::size_t dropped = 0;
  while (dropped < kLingerBytes && Clock::now() < end) {
    pollfd ready{socket, POLLIN, 0};
    if (::poll(&ready, 1, static_cast<int>(kGlance.count())) < 0) break;
    const ssize_t got = ::recv(socket, sink, sizeof sink, MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN)) break;
    if (got > 0) dropped += static_cast<std::size_t>(got);
  }
  ::close(socket);
}

// A POST that announces no body has none (RFC 9112, 6.3); the library would read on until the peer hangs up.
void expect_announced_body(httplib::Request& request) {
  if (!request.has_header("Content-Length") && !request.has_header("Transfer-Encoding"))
    request.set_header("Content-Length", "0");
}

}  // namespace

// ---- HttpPool ----

HttpPool::HttpPool(int threads, std::size_t waiting, std::atomic<int>& crowd)
    : most_waiting_(waiting), crowd_(crowd) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

bool HttpPool::refusing() {
  return refusing_now;
}

void HttpPool::enqueue(std::function<void()> task) {
  MutexLock lock(mutex_);
  if (tasks_.size() >= most_waiting_) {
    lock.unlock();
    refusing_now = true;
    task();
    refusing_now = false;
    return;
  }
  tasks_.push_back(std::move(task));
  crowd_ = static_cast<int>(tasks_.size());
  lock.unlock();
  wake_.notify_one();
}

void HttpPool::shutdown() {
  {
    const MutexLock lock(mutex_);
    closing_ = true;
    crowd_ = 1;  // whoever still dawdles is given up soon
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void HttpPool::work() {
  for (;;) {
    MutexLock lock(mutex_);
    while (!closing_ && tasks_.empty()) lock.wait(wake_);
    if (tasks_.empty()) return;
    std::function<void()> task = std::move(tasks_.front());
    tasks_.pop_front();
    const bool closing = closing_;
    crowd_ = closing ? 1 : static_cast<int>(tasks_.size());
    lock.unlock();
    refusing_now = closing;
    task();
    refusing_now = false;
  }
}

// ---- HttpServer ----

HttpServer::HttpServer(const HttpLimits& limits, std::function<void(const std::string&)> given_up)
    : limits_(limits), given_up_(std::move(given_up)) {
  new_task_queue = [this] { return new HttpPool(limits_.threads, limits_.waiting, crowd_); };
  set_payload_max_length(limits_.request_bytes);
  // The library's default shares the port with whoever else asks for it (SO_REUSEPORT).
  set_socket_options([](socket_t socket) {
    const int on = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    ::fcntl(socket, F_SETFD, FD_CLOEXEC);
  });
}

int HttpServer::bind(const std::string& host, int port) {
  if (port == 0) {
    port = bind_to_any_port(host);
  } else if (!bind_to_port(host, port)) {
    port = -1;
  }
  // The library's backlog of 5 drops connections, and a dropped one comes back after a second.
  if (port > 0) ::listen(svr_sock_, kBacklog);
  return port;
}

bool HttpServer::process_and_close_socket(socket_t socket) {
  if (HttpPool::refusing()) {
    ::close(socket);
    return false;
  }
  ::fcntl(socket, F_SETFD, FD_CLOEXEC);
  PatientStream stream(socket, limits_, crowd_);
  bool closed = false;
  const bool answered = process_request(stream, true, closed, expect_announced_body);
  if (answered) {
    linger_and_close(socket);
  } else {
    if (stream.begun()) given_up_(peer_address(socket));
    ::close(socket);
  }
  return answered;
}

// ---- addresses ----

bool HostPort::loopback() const {
  return is_loopback_host(host.find(':') == std::string::npos ? host : "[" + host + "]");
}

bool parse_host_port(const std::string& text, HostPort& out) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return false;
  std::string host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string::npos) {
    return false;
  }
  const char* first = text.data() + colon + 1;
  const char* last = text.data() + text.size();
  int port = -1;
  const auto [end, problem] = std::from_chars(first, last, port);
  if (host.empty() || problem != std::errc() || end != last || port < 0 || port > 65535) return false;
  out = {host, port};
  return true;
}

bool is_loopback_host(const std::string& host_header) {
  std::string host = host_header;
  if (!host.empty() && host.front() == '[') {
    host = host.substr(0, host.find(']') + 1);
    return host == "[::1]";
  }
  host = host.substr(0, host.find(':'));
  if (host == "localhost") return true;
  // 127.0.0.0/8, written as four numbers: "127.evil.example" is a name like any other.
  int parts = 0, digits = 0;
  for (const char c : host) {
    if (c == '.') {
      if (digits == 0) return false;
      ++parts;
      digits = 0;
    } else if (c < '0' || c > '9' || ++digits > 3) {
      return false;
    }
  }
  return parts == 3 && digits > 0 && host.rfind("127.", 0) == 0;
}

}  // namespace evograsp::server

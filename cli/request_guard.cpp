#include "cli/request_guard.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <utility>

namespace evograsp::cli {
namespace {

std::uint64_t received_by(int socket) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (socket < 0 || getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return 0;
  return info.tcpi_bytes_received;  // stays 0 on kernels that do not count
}

}  // namespace

RequestGuard::RequestGuard(std::function<void()> stop, const std::atomic<int>& socket,
                           std::chrono::seconds time, std::uint64_t bytes)
    : stop_(std::move(stop)),
      socket_(socket),
      end_(std::chrono::steady_clock::now() + time),
      bytes_(bytes + received_by(socket)),  // a connection that has served before
      thread_([this] { run(); }) {}

RequestGuard::~RequestGuard() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void RequestGuard::run() {
  constexpr auto kLook = std::chrono::milliseconds(20);
  std::unique_lock<std::mutex> lock(mutex_);
  while (!changed_.wait_for(lock, kLook, [this] { return done_; })) {
    if (std::chrono::steady_clock::now() >= end_ || received_by(socket_) > bytes_) stopped_ = true;
    if (stopped_) stop_();
  }
}

}  // namespace evograsp::cli

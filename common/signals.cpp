#include "common/signals.h"

#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace evograsp {

namespace {
constexpr std::chrono::milliseconds kCopies{300};
}

sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int number : {SIGINT, SIGTERM}) sigaddset(&set, number);
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) != 0 || hangup.sa_handler != SIG_IGN) sigaddset(&set, SIGHUP);
  return set;
}

SignalWatch::SignalWatch() {
  const sigset_t set = stop_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signals_ = signalfd(-1, &set, SFD_CLOEXEC);
  end_ = eventfd(0, EFD_CLOEXEC);
}

SignalWatch::~SignalWatch() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(end_, &one, sizeof one);
  if (thread_.joinable()) thread_.join();
  close(signals_);
  close(end_);
}

void SignalWatch::end_at_signal() {
  {
    const MutexLock lock(mutex_);
    end_at_once_ = true;
  }
  thread_ = std::thread([this] { watch(); });
}

void SignalWatch::start(std::function<void()> first) {
  {
    const MutexLock lock(mutex_);
    first_ = std::move(first);
    end_at_once_ = false;
  }
  if (!thread_.joinable()) thread_ = std::thread([this] { watch(); });
}

void SignalWatch::watch() {
  std::optional<std::chrono::steady_clock::time_point> asked;
  for (;;) {
    pollfd items[] = {{signals_, POLLIN, 0}, {end_, POLLIN, 0}};
    if (poll(items, 2, -1) < 0) continue;
    if (items[1].revents != 0) return;
    signalfd_siginfo info;
    if (read(signals_, &info, sizeof info) != static_cast<ssize_t>(sizeof info)) continue;
    const auto now = std::chrono::steady_clock::now();
    if (asked && now - *asked > kCopies) _exit(130);
    if (asked) continue;
    asked = now;
    const MutexLock lock(mutex_);
    if (end_at_once_) _exit(130);
    if (first_) first_();
  }
}

void SignalWatch::forget() {
  const MutexLock lock(mutex_);
  first_ = nullptr;
}

void notify_service_manager(const char* state) {
  const char* path = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};
  if (path == nullptr || std::strlen(path) >= sizeof address.sun_path) return;
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path);
  if (address.sun_path[0] == '@') address.sun_path[0] = '\0';  // an abstract name
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return;
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + std::strlen(path));
  sendto(fd, state, std::strlen(state), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), length);
  close(fd);
}

}  // namespace evograsp

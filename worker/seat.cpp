#include "worker/seat.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <random>
#include <string_view>
#include <utility>

#include "common/digest.h"

namespace evograsp::worker {

namespace {

constexpr int kSeats = 4096;
constexpr std::size_t kDigits = 8;

// Empty: the system does not say.
std::string place(const std::string& master) {
  std::string boot;
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::getline(file, boot);
  std::array<char, 64> network{};
  const ssize_t size = readlink("/proc/self/ns/net", network.data(), network.size());
  if (boot.empty() || size <= 0) return {};
  const std::string_view space(network.data(), static_cast<std::size_t>(size));
  return sha256_hex(boot + "\n" + std::string(space) + "\n" + master).substr(0, kDigits);
}

// An abstract name: the kernel frees it with the process, and leaves no file.
bool bind_to(int fd, const std::string& name) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  name.copy(address.sun_path + 1, sizeof address.sun_path - 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0;
}

std::string random_name() {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "-%d-%04x", static_cast<int>(getpid()),
                std::random_device{}() & 0xffff);
  return host_name() + text.data();
}

}  // namespace

std::string host_name() {
  char name[128] = {};
  gethostname(name, sizeof name - 1);
  return name;
}

Seat::~Seat() {
  if (fd_ >= 0) close(fd_);
}

Seat::Seat(Seat&& other) noexcept : name_(std::move(other.name_)), fd_(std::exchange(other.fd_, -1)) {}

Seat Seat::take(const std::string& master) {
  Seat seat;
  const std::string here = place(master);
  seat.fd_ = here.empty() ? -1 : socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  for (int number = 1; seat.fd_ >= 0 && number <= kSeats; ++number) {
    const std::string own = here + "-" + std::to_string(number);
    if (bind_to(seat.fd_, "evograsp-worker-" + own)) {
      seat.name_ = host_name() + "-" + own;
      return seat;
    }
    if (errno != EADDRINUSE) break;
  }
  seat.name_ = random_name();
  return seat;
}

}  // namespace evograsp::worker

// A TCP relay that a test puts between worker and master: slow, late, silent, or well.
#pragma once

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace evograsp::testing {

class Relay {
 public:
  struct Link {
    double delay_seconds = 0;     // each way
    double bytes_a_second = 1e9;  // each way, of each connection
  };
  Relay(const std::string& endpoint, Link link) : link_(link), target_(port_of(endpoint)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 64) != 0)
      std::abort();
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    endpoint_ = "tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this] { run(); });
  }
  ~Relay() {
    stopping_ = true;
    thread_.join();
    for (auto& pipe : pipes_) pipe->close_both();
    close(listener_);
  }
  const std::string& endpoint() const { return endpoint_; }
  // Nothing passes, and nobody is told: what a pulled cable looks like.
  void cut() { cut_ = true; }
  void restore() { cut_ = false; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Chunk {
    Clock::time_point due;
    std::string bytes;
  };
  struct Way {  // one direction
    int from, to;
    std::deque<Chunk> queue;
    double allowance = 0;
  };
  struct Pipe {
    Way ways[2];
    bool broken = false;
    void close_both() {
      close(ways[0].from);
      close(ways[0].to);
    }
  };

  static int port_of(const std::string& endpoint) {
    return std::stoi(endpoint.substr(endpoint.rfind(':') + 1));
  }
  static sockaddr_in loopback(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }

  void run() {
    auto before = Clock::now();
    while (!stopping_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const auto now = Clock::now();
      const double passed = std::chrono::duration<double>(now - before).count();
      before = now;
      if (cut_) continue;
      accept_waiting();
      for (auto& pipe : pipes_)
        for (Way& way : pipe->ways) pipe->broken = !move(way, now, passed) || pipe->broken;
      std::erase_if(pipes_, [](const auto& pipe) {
        if (pipe->broken) pipe->close_both();
        return pipe->broken;
      });
    }
  }

  void accept_waiting() {
    pollfd waiting{listener_, POLLIN, 0};
    while (poll(&waiting, 1, 0) > 0) {
      const int from = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      const int to = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_in address = loopback(target_);
      const int on = 1;
      setsockopt(to, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      setsockopt(from, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      if (::connect(to, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        close(from);
        close(to);
        continue;
      }
      auto pipe = std::make_unique<Pipe>();
      pipe->ways[0] = {from, to, {}, 0};
      pipe->ways[1] = {to, from, {}, 0};
      pipes_.push_back(std::move(pipe));
    }
  }

  // False when the connection has ended.
  bool move(Way& way, Clock::time_point now, double passed) {
    way.allowance = std::min(way.allowance + passed * link_.bytes_a_second, link_.bytes_a_second * 0.5 + 1);
    char buffer[65536];
    const auto delay =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(link_.delay_seconds));
    while (way.allowance >= 1 && way.queue.size() < 10000) {
      const auto most = std::min(sizeof buffer, static_cast<std::size_t>(way.allowance));
      const ssize_t got = recv(way.from, buffer, most, MSG_DONTWAIT);
      if (got == 0) return false;
      if (got < 0) break;
      way.allowance -= static_cast<double>(got);
      way.queue.push_back({now + delay, std::string(buffer, static_cast<std::size_t>(got))});
    }
    while (!way.queue.empty() && way.queue.front().due <= now) {
      std::string& bytes = way.queue.front().bytes;
      const ssize_t sent = ::send(way.to, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (sent < 0) return errno == EAGAIN;
      bytes.erase(0, static_cast<std::size_t>(sent));
      if (!bytes.empty()) break;
      way.queue.pop_front();
    }
    return true;
  }

  const Link link_;
  const int target_;
  int listener_ = -1;
  std::string endpoint_;
  std::vector<std::unique_ptr<Pipe>> pipes_;
  std::atomic<bool> cut_{false}, stopping_{false};
  std::thread thread_;
};

}  // namespace evograsp::testing

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
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/random.h"

namespace evograsp::testing {

class Relay {
 public:
  struct Link {
    double delay_seconds = 0;     // each way
    double bytes_a_second = 1e9;  // each way, of each connection
    double loss = 0;              // share of the chunks that come a retransmission later, and all behind them
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
  // Connections are reset, new ones as well: what a restarted switch or firewall looks like.
  void reset() { resetting_ = true; }
  void restore() { cut_ = resetting_ = false; }
  void set_link(Link link) {
    const std::lock_guard lock(mutex_);
    link_ = link;
  }
  std::size_t connections() const { return connections_; }
  // Connections that were reset or bytes that came late by a loss, so far.
  std::size_t resets() const { return resets_; }
  std::size_t losses() const { return losses_; }
  // What the last connection said first, to whoever it is that it connected to.
  std::string recorded() const {
    const std::lock_guard lock(mutex_);
    return recorded_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kRetransmission = 0.2;  // the kernel's least
  static constexpr std::size_t kRecorded = 1 << 20;
  struct Chunk {
    Clock::time_point due;
    std::string bytes;
  };
  struct Way {  // one direction
    int from, to;
    bool recorded = false;
    std::deque<Chunk> queue{};
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
      if (resetting_) resets_ += pipes_.size();
      const Link link = current();
      for (auto& pipe : pipes_)
        for (Way& way : pipe->ways)
          pipe->broken = resetting_ || !move(way, link, now, passed) || pipe->broken;
      std::erase_if(pipes_, [](const auto& pipe) {
        if (pipe->broken) pipe->close_both();
        return pipe->broken;
      });
      connections_ = pipes_.size();
    }
  }

  Link current() const {
    const std::lock_guard lock(mutex_);
    return link_;
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
      pipe->ways[0] = {from, to, true};
      pipe->ways[1] = {to, from};
      const std::lock_guard lock(mutex_);
      recorded_.clear();
      pipes_.push_back(std::move(pipe));
    }
  }

  // False when the connection has ended.
  bool move(Way& way, const Link& link, Clock::time_point now, double passed) {
    way.allowance = std::min(way.allowance + passed * link.bytes_a_second, link.bytes_a_second * 0.5 + 1);
    char buffer[65536];
    while (way.allowance >= 1 && way.queue.size() < 10000) {
      const auto most = std::min(sizeof buffer, static_cast<std::size_t>(way.allowance));
      const ssize_t got = recv(way.from, buffer, most, MSG_DONTWAIT);
      if (got == 0) return false;
      if (got < 0) break;
      way.allowance -= static_cast<double>(got);
      double delay = link.delay_seconds;
      if (link.loss > 0 && random_.chance(link.loss)) {
        delay += kRetransmission;
        ++losses_;
      }
      std::string bytes(buffer, static_cast<std::size_t>(got));
      if (way.recorded) record(bytes);
      way.queue.push_back(
          {now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(delay)),
           std::move(bytes)});
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

  void record(const std::string& bytes) {
    const std::lock_guard lock(mutex_);
    if (recorded_.size() < kRecorded) recorded_ += bytes;
  }

  mutable std::mutex mutex_;
  Link link_;             // guarded
  std::string recorded_;  // guarded
  Random random_{1, Purpose::kTestHarness};
  const int target_;
  int listener_ = -1;
  std::string endpoint_;
  std::vector<std::unique_ptr<Pipe>> pipes_;
  std::atomic<bool> cut_{false}, resetting_{false}, stopping_{false};
  std::atomic<std::size_t> connections_{0}, resets_{0}, losses_{0};
  std::thread thread_;
};

}  // namespace evograsp::testing

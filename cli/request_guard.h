// An end to what a server sends, whatever it is.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

namespace evograsp::cli {

// Lives as long as one request. Calls `stop` again and again from a thread of its own once the request has
// taken longer than `time`, or more than `bytes` have come in by the TCP socket `socket` (-1: none yet):
// headers without end count as a body does, and a byte now and then is no progress.
class RequestGuard {
 public:
  RequestGuard(std::function<void()> stop, const std::atomic<int>& socket, std::chrono::seconds time,
               std::uint64_t bytes);
  ~RequestGuard();
  RequestGuard(const RequestGuard&) = delete;
  RequestGuard& operator=(const RequestGuard&) = delete;

  bool stopped() const { return stopped_; }

 private:
  void run();

  const std::function<void()> stop_;
  const std::atomic<int>& socket_;
  const std::chrono::steady_clock::time_point end_;
  const std::uint64_t bytes_;
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  std::thread thread_;
};

}  // namespace evograsp::cli

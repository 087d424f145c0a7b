// cpp-httplib made fit for strangers.
//
// The library answers well but waits badly: one pool thread sits with each open connection, for as long as
// its peer cares to send a byte now and then. Here every connection carries one request with a deadline on
// the whole of it and a bound on its bytes, threads and waiting connections are counted, and while others
// wait a dawdling peer is given up sooner.
#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/mutex.h"
namespace evograsp::server {

struct HttpLimits {
  int threads = 16;
  std::size_t waiting = 256;                  // connections; more are closed unanswered
  std::size_t request_bytes = 32 * 1024;      // line, headers and body
  std::chrono::milliseconds request{5000};    // from accept to the last byte of the request
  std::chrono::milliseconds response{10000};  // to write the answer
  std::chrono::milliseconds crowded{300};     // both, while other connections wait
};

// A bounded pool. Connections beyond the bound are handed to a worker thread only to be closed.
class HttpPool final : public httplib::TaskQueue {
 public:
  HttpPool(int threads, std::size_t waiting, std::atomic<int>& crowd);
  void enqueue(std::function<void()> task) override;
  void shutdown() override;
  // Whether the running task is one too many.
  static bool refusing();

 private:
  void work();
  const std::size_t most_waiting_;
  std::atomic<int>& crowd_;  // tasks waiting now
  Mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> tasks_ GUARDED_BY(mutex_);
  bool closing_ GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

// An httplib::Server of one request a connection. Routes, handlers and hooks are the library's.
class HttpServer final : public httplib::Server {
 public:
  // given_up: told the address of each peer whose request was begun and never answered. On any thread.
  HttpServer(const HttpLimits& limits, std::function<void(const std::string& peer)> given_up);
  // Binds; the port, or -1. Port 0: any free one.
  int bind(const std::string& host, int port);

 private:
  bool process_and_close_socket(socket_t socket) override;
  const HttpLimits limits_;
  const std::function<void(const std::string&)> given_up_;
  std::atomic<int> crowd_{0};
};

// "host:port" or "[v6]:port".
struct HostPort {
  std::string host;
  int port = 0;
  bool loopback() const;
};
// false when `text` is neither; port 0 asks for any free one.
bool parse_host_port(const std::string& text, HostPort& out);
// Whether a Host header's value names this machine's loopback (any port).
bool is_loopback_host(const std::string& host_header);

}  // namespace evograsp::server

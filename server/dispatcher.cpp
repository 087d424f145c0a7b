#include "server/dispatcher.h"

#include <deque>
#include <exception>
#include <thread>
#include <utility>

#include "common/last_words.h"
#include "common/mutex.h"
#include "common/thread_name.h"
#include "server/dispatch_loop.h"

namespace evograsp::server {

namespace {

class DispatcherThread : public Dispatcher {
 public:
  DispatcherThread(std::unique_ptr<DispatchLoop> loop, std::vector<std::string> endpoints, WorkSink& sink)
      : endpoints_(std::move(endpoints)), sink_(sink), owned_(std::move(loop)), thread_([this] { run(); }) {}

  ~DispatcherThread() override {
    post({});
    thread_.join();
    // What workers were told last should reach them.
    loop_.router().set(zmq::sockopt::linger, 200);
  }

  void begin(Work work) override {
    post([shared = std::make_shared<Work>(std::move(work))](DispatchLoop& loop) {
      loop.begin(std::move(*shared));
    });
  }
  void add(std::uint32_t first, std::vector<NetworkFrame> networks) override {
    post([first, shared = std::make_shared<std::vector<NetworkFrame>>(std::move(networks))](
             DispatchLoop& loop) { loop.add(first, std::move(*shared)); });
  }
  void abandon() override {
    post([](DispatchLoop& loop) { loop.abandon(); });
  }
  void set_paused(bool paused) override {
    post([paused](DispatchLoop& loop) { loop.set_paused(paused); });
  }
  void set_drained(std::string node, bool drained) override {
    post([name = std::move(node), drained](DispatchLoop& loop) { loop.set_drained(name, drained); });
  }
  void dismiss(std::string reason) override {
    post([text = std::move(reason)](DispatchLoop& loop) { loop.dismiss(text); });
  }

  DispatchView view() const override {
    const MutexLock lock(mutex_);
    return view_;
  }
  std::vector<std::string> endpoints() const override { return endpoints_; }

 private:
  using Command = std::function<void(DispatchLoop&)>;  // empty: end

  void post(Command command) {
    {
      const MutexLock lock(mutex_);
      commands_.push_back(std::move(command));
    }
    wakeup_.notify();
  }

  void run() {
    name_thread("dispatch");
    try {
      while (obey()) {
        wait();
        loop_.drop_disconnected();
        while (loop_.receive_some() && !tick_due()) {
        }
        if (tick_due()) tick();
      }
    } catch (const std::exception& error) {
      sink_.broken(error_of_exception(error));
    }
  }

  // Runs what other threads have asked for; false when one of them asked for the end.
  bool obey() {
    std::deque<Command> commands;
    {
      const MutexLock lock(mutex_);
      commands.swap(commands_);
    }
    for (const Command& command : commands) {
      if (!command) return false;
      command(loop_);
    }
    return true;
  }

  void wait() {
    zmq::pollitem_t items[] = {{loop_.router().handle(), 0, ZMQ_POLLIN, 0},
                               {loop_.monitor().handle(), 0, ZMQ_POLLIN, 0},
                               {nullptr, wakeup_.fd(), ZMQ_POLLIN, 0}};
    zmq::poll(items, 3, std::chrono::milliseconds(static_cast<int>(loop_.tick_seconds() * 1000)));
    if (items[2].revents != 0) wakeup_.clear();
  }

  bool tick_due() const { return std::chrono::steady_clock::now() >= next_tick_; }

  void tick() {
    loop_.tick();
    const auto now = std::chrono::steady_clock::now();
    next_tick_ = now + std::chrono::microseconds(static_cast<int>(loop_.tick_seconds() * 1e6));
    if (now < next_view_) return;
    next_view_ = now + std::chrono::milliseconds(200);
    DispatchView view = loop_.view();
    const MutexLock lock(mutex_);
    view_ = std::move(view);
  }

  const std::vector<std::string> endpoints_;
  WorkSink& sink_;
  Wakeup wakeup_;

  mutable Mutex mutex_;
  std::deque<Command> commands_ GUARDED_BY(mutex_);
  DispatchView view_ GUARDED_BY(mutex_);

  // The thread's own.
  const std::unique_ptr<DispatchLoop> owned_;
  DispatchLoop& loop_ = *owned_;
  std::chrono::steady_clock::time_point next_tick_, next_view_;
  std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<Dispatcher>> Dispatcher::create(zmq::context_t& context, DispatcherOptions options,
                                                       WorkSink& sink) {
  auto router = make_router(context, options.socket);
  if (!router) return tl::unexpected(router.error());
  try {
    const std::vector<std::string> endpoints = options.endpoints;
    auto loop = std::make_unique<DispatchLoop>(context, std::move(*router), std::move(options), sink);
    std::vector<std::string> bound;
    for (const std::string& endpoint : endpoints) {
      auto real = bind(loop->router(), endpoint);
      if (!real) return tl::unexpected(real.error());
      bound.push_back(std::move(*real));
    }
    return std::make_unique<DispatcherThread>(std::move(loop), std::move(bound), sink);
  } catch (const std::exception& error) {
    return tl::unexpected(error_of_exception(error));
  }
}

}  // namespace evograsp::server

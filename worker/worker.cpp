#include "worker/worker.h"

#include <atomic>
#include <new>
#include <system_error>
#include <thread>

#include "worker/seat.h"
#include "worker/session.h"

namespace evograsp::worker {

namespace {

class WorkerImpl : public Worker {
 public:
  WorkerImpl(WorkerOptions options, Seat seat) : options_(std::move(options)), seat_(std::move(seat)) {
    if (options_.context == nullptr) own_context_ = std::make_unique<zmq::context_t>(1);
  }

  Status run() override {
    zmq::context_t& context = options_.context != nullptr ? *options_.context : *own_context_;
    try {
      Session session(context, options_, wakeup_, order_);
      return session.run();
    } catch (const std::system_error& error) {  // no threads for the slots
      return fail(ErrorCode::kUsage, error.what());
    } catch (const std::bad_alloc&) {
      return fail(ErrorCode::kIo, "not enough memory for this experiment on this machine");
    } catch (const std::exception& error) {
      return fail(ErrorCode::kInternal, options_.connect + ": " + error.what());
    }
  }
  void drain() override {
    int serving = Session::kServe;
    order_.compare_exchange_strong(serving, Session::kDrain);
    wakeup_->notify();
  }
  void stop() override {
    order_ = Session::kStop;
    wakeup_->notify();
  }

 private:
  WorkerOptions options_;
  const Seat seat_;
  std::unique_ptr<zmq::context_t> own_context_;
  const std::shared_ptr<Wakeup> wakeup_ = std::make_shared<Wakeup>();
  std::atomic<int> order_{Session::kServe};
};

}  // namespace

Result<std::unique_ptr<Worker>> Worker::create(WorkerOptions options) {
  if (options.slots < 0 || options.slots > 4096)
    return fail(ErrorCode::kUsage, "slots: " + std::to_string(options.slots) + " is not between 1 and 4096");
  if (options.slots == 0) options.slots = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Seat seat = options.identity.empty()
                  ? Seat::take(options.rendezvous.empty() ? options.connect : options.rendezvous)
                  : Seat();
  if (options.identity.empty()) options.identity = seat.name();
  if (options.host.empty()) options.host = host_name();
  if (options.identity.size() > 200) return fail(ErrorCode::kUsage, "identity: longer than 200 characters");
  if (options.host.size() > 200) return fail(ErrorCode::kUsage, "host: longer than 200 characters");
  return std::make_unique<WorkerImpl>(std::move(options), std::move(seat));
}

}  // namespace evograsp::worker

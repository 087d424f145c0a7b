// The faults of the soak, one function each.
#include <sys/socket.h>

#include "common/version.h"
#include "common/wire.h"
#include "tests/server/raw_connection.h"
#include "tests/soak/soak_run.h"

namespace evograsp::soak {

using testing::Process;

const std::vector<SoakRun::Fault>& SoakRun::faults() {
  static const std::vector<Fault> all = {
      {"master killed -9", 24, &SoakRun::kill_server},
      {"master told to stop", 4, &SoakRun::stop_server},
      {"worker killed -9", 16, &SoakRun::kill_worker},
      {"worker preempted", 8, &SoakRun::preempt_worker},
      {"worker frozen", 8, &SoakRun::freeze_worker},
      {"worker slow by 30", 4, &SoakRun::slow_worker},
      {"worker lies", 4, &SoakRun::lying_worker},
      {"link cut silently", 4, &SoakRun::cut_link},
      {"identity used twice", 4, &SoakRun::twin_identity},
      {"another protocol version", 4, &SoakRun::other_protocol},
      {"garbage from a stranger", 6, &SoakRun::garbage},
      {"half-open connections", 4, &SoakRun::half_open},
      {"worker with a wrong clock", 4, &SoakRun::wrong_clock},
  };
  return all;
}

std::size_t SoakRun::some_worker() {
  return random_.below(static_cast<std::uint32_t>(workers_.size()));
}

void SoakRun::kill_server() {
  if (server_->finish(SIGKILL) == 0) return;  // it had just finished
  const Journal before = read_journal(folder_ / "run");
  if (!check_resumed(before)) return;
  start_server(true);
}

void SoakRun::stop_server() {
  const int code = server_->finish(SIGTERM);
  if (code == 0) return;
  if (code != 130 && code != -SIGTERM) {
    complain("a server told to stop ended with " + std::to_string(code));
    return;
  }
  if (check_resumed(read_journal(folder_ / "run"))) start_server(true);
}

void SoakRun::kill_worker() {
  workers_[some_worker()]->finish(SIGKILL);
}

// Told to go, and not given the time.
void SoakRun::preempt_worker() {
  Process& worker = *workers_[some_worker()];
  worker.signal(SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(random_.below(30)));
  worker.finish(SIGKILL);
}

void SoakRun::freeze_worker() {
  Process& worker = *workers_[some_worker()];
  worker.signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(200 + random_.below(2500)));
  worker.signal(SIGCONT);
}

void SoakRun::slow_worker() {
  const std::size_t slot = some_worker();
  workers_[slot]->finish(SIGTERM);
  start_worker(slot, "sleep:0.12");
}

void SoakRun::lying_worker() {
  const std::size_t slot = some_worker();
  workers_[slot]->finish(SIGTERM);
  start_worker(slot, "lie");
}

void SoakRun::cut_link() {
  relay_->cut();
  std::this_thread::sleep_for(std::chrono::milliseconds(500 + random_.below(3000)));
  relay_->restore();
}

void SoakRun::twin_identity() {
  others_.clear();
  others_.push_back(
      std::make_unique<Process>("evograsp-worker",
                                std::vector<std::string>{"--connect", endpoint_, "--slots", "1", "--identity",
                                                         "worker-" + std::to_string(worker_starts_ - 1)},
                                folder_ / "twin"));
}

void SoakRun::other_protocol() {
  zmq::context_t context(1);
  auto socket = std::move(*make_dealer(context, endpoint_, {}));
  proto::Envelope envelope = make_envelope({});
  envelope.set_protocol(kProtocolVersion + 1);
  envelope.mutable_hello()->set_identity("from-tomorrow");
  send(socket, {}, envelope);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

void SoakRun::garbage() {
  const int fd = testing::raw_connection(endpoint_);
  if (fd < 0) return;
  std::string bytes(20000, '\0');
  for (char& b : bytes) b = static_cast<char>(random_.next());
  static_cast<void>(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
  close(fd);
}

void SoakRun::half_open() {
  for (const int fd : held_open_) close(fd);
  held_open_.clear();
  for (int i = 0; i < 50; ++i)
    if (const int fd = testing::raw_connection(endpoint_); fd >= 0) held_open_.push_back(fd);
}

void SoakRun::wrong_clock() {
  const std::size_t slot = some_worker();
  workers_[slot]->finish(SIGTERM);
  const std::string name = "worker-" + std::to_string(worker_starts_++);
  workers_[slot] = std::make_unique<Process>(
      "evograsp-worker", std::vector<std::string>{"--connect", endpoint_, "--identity", name, "--slots", "1"},
      folder_ / name,
      std::vector<std::string>{std::string("LD_PRELOAD=") + EVOGRASP_WRONG_CLOCK,
                               "EVOGRASP_CLOCK_OFFSET=" + std::to_string(random_.below(1000000000))});
}

}  // namespace evograsp::soak

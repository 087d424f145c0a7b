// The faults of the soak, one function each: of the master, its workers and the network between them.
#include <cstdio>
#include <utility>

#include "tests/soak/soak_run.h"

namespace evograsp::soak {

using testing::Process;
using Clock = std::chrono::steady_clock;

const std::vector<SoakRun::Fault>& SoakRun::faults() {
  static const std::vector<Fault> all = {
      {"master killed -9", 20, &SoakRun::kill_server},
      {"master told to stop", 4, &SoakRun::stop_server},
      {"master frozen", 3, &SoakRun::freeze_server},
      {"worker killed -9", 14, &SoakRun::kill_worker},
      {"worker preempted", 8, &SoakRun::preempt_worker},
      {"worker frozen", 6, &SoakRun::freeze_worker},
      {"worker slow by 30", 3, &SoakRun::slow_worker},
      {"worker lies", 4, &SoakRun::lying_worker},
      {"worker hangs in a grasp", 3, &SoakRun::hung_worker},
      {"worker crashes in a grasp", 3, &SoakRun::crashing_worker},
      {"worker with a wrong clock", 3, &SoakRun::wrong_clock},
      {"worker of another build", 3, &SoakRun::other_build},
      {"identity used twice", 4, &SoakRun::twin_identity},
      {"link cut silently, and back", 4, &SoakRun::cut_link},
      {"link down with resets, and up", 4, &SoakRun::reset_link},
      {"link late and lossy", 4, &SoakRun::lossy_link},
      {"another protocol version", 3, &SoakRun::other_protocol},
      {"garbage from a stranger", 4, &SoakRun::garbage},
      {"half-open connections", 3, &SoakRun::half_open},
      {"a flood of tiny frames", 3, &SoakRun::tiny_frames},
      {"an oversized frame", 3, &SoakRun::oversized_frame},
      {"a session's bytes replayed", 4, &SoakRun::replayed_bytes},
      {"stranger with a wrong key", 3, &SoakRun::wrong_key},
      {"stranger without a key", 3, &SoakRun::no_key},
      {"HTTP: requests never ended", 3, &SoakRun::http_dawdler},
      {"HTTP: no token", 3, &SoakRun::http_without_token},
      {"HTTP: path tricks", 3, &SoakRun::http_path_tricks},
      {"disk full", 4, &SoakRun::full_disk},
      {"disk read-only", 4, &SoakRun::read_only_disk},
      {"byte of run.db flipped", 12, &SoakRun::flipped_byte},
  };
  return all;
}

// ---- the master ----

// Killed, after a look at what it has journalled; false when it had just finished.
bool SoakRun::take_down() {
  remember();
  return good_ && server_->finish(SIGKILL) == -SIGKILL && check_kept();
}

bool SoakRun::kill_server() {
  if (!take_down()) return false;
  start_server();
  return true;
}

bool SoakRun::stop_server() {
  remember();
  const int code = server_->finish(SIGTERM);
  if (code == 0) return false;
  if (code != 130 && code != -SIGTERM)  // -SIGTERM: it had not begun to listen to signals
    return complain("a server told to stop ended with " + std::to_string(code));
  if (!check_kept()) return false;
  start_server();
  return true;
}

bool SoakRun::freeze_server() {
  if (server_->ended()) return false;
  server_->signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(200 + random_.below(2300)));
  server_->signal(SIGCONT);
  return true;
}

// Its workers ride it out, and go on when it is back.
bool SoakRun::stay_away() {
  keep_workers();
  if (!wait_for([&] { return server_->ended() || (serves(0) && serves(1) && serves(2)); }, 20)) return false;
  if (!take_down()) return false;
  std::this_thread::sleep_for(std::chrono::seconds(150));
  for (Member& worker : workers_)
    if (worker.process->ended())
      return complain(worker.name + " did not outlive its master: " + log_text(worker.name));
  const auto welcomes = [&] {
    std::size_t all = 0;
    for (const Member& worker : workers_) {
      const std::string text = log_text(worker.name);
      for (std::size_t at = 0; (at = text.find("welcome", at)) != std::string::npos; ++at) ++all;
    }
    return all;
  };
  const std::size_t welcomed = welcomes();
  start_server();
  const auto back = Clock::now();
  if (!wait_for([&] { return server_->ended() || welcomes() >= welcomed + workers_.size(); }, 20))
    return complain("not every worker found the master that was back after 150 s");
  std::printf("a master that was away for 150 s had its workers back after %.2f s\n",
              std::chrono::duration<double>(Clock::now() - back).count());
  return true;
}

// ---- workers ----

bool SoakRun::kill_worker() {
  const std::size_t slot = some_worker();
  return serves(slot) && workers_[slot].process->finish(SIGKILL) == -SIGKILL;
}

// Told to go, and not given the time.
bool SoakRun::preempt_worker() {
  const std::size_t slot = some_worker();
  if (!serves(slot)) return false;
  workers_[slot].process->signal(SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(random_.below(30)));
  workers_[slot].process->finish(SIGKILL);
  return true;
}

bool SoakRun::freeze_worker() {
  const std::size_t slot = some_worker();
  if (!serves(slot)) return false;
  workers_[slot].process->signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(200 + random_.below(2500)));
  workers_[slot].process->signal(SIGCONT);
  return true;
}

// By one whose fault shows later, if it lives so long.
bool SoakRun::replace_worker(const std::string& fault, const std::string& proof) {
  const std::size_t slot = some_worker();
  workers_[slot].process->finish(SIGTERM);
  start_worker(slot, fault);
  prove_later(workers_[slot].name, proof);
  return false;
}

bool SoakRun::slow_worker() {
  return replace_worker("sleep:0.12", "welcome");
}

// One in a run: two that tell the same lie are right against one (docs/THREAT-MODEL.md), even one after the
// other when nobody else came to decide.
bool SoakRun::lying_worker() {
  if (std::exchange(lied_, true)) return false;
  return replace_worker("lie", "quarantined");
}

bool SoakRun::hung_worker() {
  return replace_worker("hang-after:" + std::to_string(random_.below(6)), "a slot hangs");
}

bool SoakRun::crashing_worker() {
  return replace_worker("abort-after:" + std::to_string(random_.below(6)), "aborts");
}

bool SoakRun::wrong_clock() {
  const std::size_t slot = some_worker();
  workers_[slot].process->finish(SIGTERM);
  const std::string name = "worker-" + std::to_string(worker_starts_++);
  workers_[slot].name = name;
  workers_[slot].process = std::make_unique<Process>(
      "evograsp-worker", worker_arguments(name, slot == 0), log_of(name),
      std::vector<std::string>{std::string("LD_PRELOAD=") + EVOGRASP_WRONG_CLOCK,
                               "EVOGRASP_CLOCK_OFFSET=" + std::to_string(random_.below(1000000000))});
  prove_later(name, "welcome");
  return false;
}

bool SoakRun::twin_identity() {
  const std::size_t slot = some_worker();
  if (!serves(slot)) return false;
  const std::string log = "twin-" + std::to_string(worker_starts_++);
  others_.push_back({std::make_unique<Process>("evograsp-worker",
                                               worker_arguments(workers_[slot].name, false), log_of(log)),
                     log});
  prove_later(log, "refuses for now");
  return false;
}

bool SoakRun::other_build() {
  const std::string name = "stale-" + std::to_string(worker_starts_++);
  others_.push_back(
      {std::make_unique<Process>("evograsp-worker-other", worker_arguments(name, false), log_of(name)),
       name});
  never_welcome_.push_back(name);
  prove_later(name, "worker build 0.0.0");
  return false;
}

// ---- the network ----

bool SoakRun::cut_link() {
  if (!serves(0) || relay_->connections() == 0) return false;
  relay_->cut();
  std::this_thread::sleep_for(std::chrono::milliseconds(500 + random_.below(3500)));
  relay_->restore();
  return true;
}

bool SoakRun::reset_link() {
  if (!serves(0)) return false;
  const std::size_t before = relay_->resets();
  relay_->reset();
  std::this_thread::sleep_for(std::chrono::milliseconds(100 + random_.below(2000)));
  relay_->restore();
  return relay_->resets() > before;
}

// Until the next such fault: 5 to 80 ms each way, up to one chunk in twenty a retransmission late.
bool SoakRun::lossy_link() {
  const std::size_t before = relay_->losses();
  relay_->set_link({0.005 + 0.001 * random_.below(75), 1e8, 0.01 * (1 + random_.below(5))});
  prove_later([this, before] { return relay_->losses() > before; });
  return false;
}

}  // namespace evograsp::soak

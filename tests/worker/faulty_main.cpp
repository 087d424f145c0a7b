// evograsp-worker-faulty: the real worker, whose evaluations go wrong as EVOGRASP_FAULT says. The linker puts
// misbehave() in the place of Evaluator::evaluate (tests/CMakeLists.txt); no shipped program has it.
//
//   lie           every measurement is off in its last bit
//   lie-after:N   the same, from the Nth task on
//   die           every task ends the process
//   abort:ID      a task with genome ID ends the process
//   hang:ID       a task with genome ID never ends
//   abort-after:N the same as abort and hang, whichever genomes the Nth task has
//   hang-after:N
//   freeze:ID     a task with genome ID stops the whole process, heartbeats and all
//   slow:FACTOR   every task takes FACTOR times as long
//   sleep:SECONDS every task takes so much longer
#include <signal.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "worker/evaluator.h"

namespace evograsp::worker {
namespace {

using Networks = std::vector<zmq::message_t>;

struct Fault {
  std::string kind;
  double number = 0;
};

Fault fault() {
  const char* text = std::getenv("EVOGRASP_FAULT");
  const std::string all = text != nullptr ? text : "";
  const auto colon = all.find(':');
  if (colon == std::string::npos) return {all, 0};
  return {all.substr(0, colon), std::strtod(all.c_str() + colon + 1, nullptr)};
}

bool concerns(const proto::Task& task, double genome) {
  for (const std::uint64_t id : task.network())
    if (static_cast<double>(id) == genome) return true;
  return false;
}

void lie(proto::TaskResult& result) {
  for (proto::Measurement& m : *result.mutable_measurement()) m.set_quality(std::nextafter(m.quality(), 1e9));
}

std::atomic<int> tasks{0};

// Whether this task is one to go wrong with, by its genomes or by its number.
bool strikes(const Fault& what, const char* kind, const proto::Task& task, int number) {
  if (what.kind == kind) return concerns(task, what.number);
  return what.kind == std::string(kind) + "-after" && number > what.number;
}

}  // namespace

void really_evaluate(Evaluator* self, const proto::Task& task, const Networks& networks,
                     proto::TaskResult& result) asm("__real_" EVOGRASP_EVALUATE);
void misbehave(Evaluator* self, const proto::Task& task, const Networks& networks,
               proto::TaskResult& result) asm("__wrap_" EVOGRASP_EVALUATE);

void misbehave(Evaluator* self, const proto::Task& task, const Networks& networks,
               proto::TaskResult& result) {
  static const Fault what = fault();
  const int number = ++tasks;
  if (what.kind == "die" || strikes(what, "abort", task, number)) {
    std::fprintf(stderr, "evograsp-worker-faulty aborts\n");
    std::abort();
  }
  while (strikes(what, "hang", task, number)) std::this_thread::sleep_for(std::chrono::seconds(1));
  if (what.kind == "freeze" && concerns(task, what.number)) raise(SIGSTOP);
  const auto start = std::chrono::steady_clock::now();
  really_evaluate(self, task, networks, result);
  if (what.kind == "slow")
    std::this_thread::sleep_for((std::chrono::steady_clock::now() - start) * (what.number - 1));
  if (what.kind == "sleep") std::this_thread::sleep_for(std::chrono::duration<double>(what.number));
  if (what.kind == "lie" || (what.kind == "lie-after" && number > what.number)) lie(result);
}

}  // namespace evograsp::worker

#include "cli/stop_signals.h"

#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "cli/report.h"
#include "common/signals.h"

namespace evograsp::cli {
namespace {

// Read by a signal's handler: no string, no lock.
enum Unfinished : int { kNone, kBeingNamed, kNamed };
std::array<char, 4096> unfinished_name{};
std::atomic<int> unfinished{kNone};
static_assert(std::atomic<int>::is_always_lock_free);

}  // namespace

UnfinishedFile::UnfinishedFile(const std::filesystem::path& file) {
  int none = kNone;
  if (file.native().size() >= unfinished_name.size() ||
      !unfinished.compare_exchange_strong(none, kBeingNamed))
    return;
  std::strcpy(unfinished_name.data(), file.c_str());
  unfinished = kNamed;
  named_ = true;
}

UnfinishedFile::~UnfinishedFile() {
  if (named_) unfinished = kNone;
}

void end_now() {
  if (unfinished == kNamed) ::unlink(unfinished_name.data());
  ::_exit(kExitInterrupted);
}

void end_at_signals() {
  const sigset_t set = stop_signals();
  struct sigaction end {};
  end.sa_handler = [](int) { end_now(); };
  end.sa_mask = set;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (sigismember(&set, signal) == 1) sigaction(signal, &end, nullptr);
}

StopSignals::StopSignals() : set_(stop_signals()) {
  pthread_sigmask(SIG_BLOCK, &set_, nullptr);
}

void StopSignals::stop() {
  done_ = true;
  if (watcher_.joinable()) watcher_.join();
  pthread_sigmask(SIG_UNBLOCK, &set_, nullptr);
}

void StopSignals::watch(std::function<void()> first) {
  watcher_ = std::thread([this, first = std::move(first)] {
    const timespec tick{0, 50'000'000};
    bool asked = false;
    while (!done_) {
      if (sigtimedwait(&set_, nullptr, &tick) < 0) continue;
      if (asked) end_now();
      asked = true;
      first();
    }
  });
}

}  // namespace evograsp::cli

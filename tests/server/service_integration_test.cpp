// What a service manager hears of the real programs: ready, alive, stopping.
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <fstream>

#include "cluster.h"

namespace evograsp::testing {
namespace {

using Words = std::vector<std::string>;

constexpr char kServer[] = EVOGRASP_BIN_DIR "/evograsp-server";
constexpr char kWorker[] = EVOGRASP_BIN_DIR "/evograsp-worker";

// The manager's end of NOTIFY_SOCKET.
class Manager {
 public:
  Manager() : fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = (dir_.path() / "notify").string();
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    const timeval patience{20, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~Manager() {
    unsetenv("NOTIFY_SOCKET");
    close(fd_);
  }
  // The next message that is not `but`; empty after 20 s of silence.
  std::string next(const std::string& but = "") {
    std::array<char, 256> text{};
    for (;;) {
      const ssize_t size = recv(fd_, text.data(), text.size(), 0);
      if (size <= 0) return {};
      const std::string message(text.data(), static_cast<std::size_t>(size));
      if (message != but) return message;
    }
  }
  // What has come already, if anything.
  std::string waiting() {
    std::array<char, 256> text{};
    const ssize_t size = recv(fd_, text.data(), text.size(), MSG_DONTWAIT);
    return size <= 0 ? std::string() : std::string(text.data(), static_cast<std::size_t>(size));
  }

 private:
  TempDir dir_;
  int fd_;
};

pid_t start(const Words& words) {
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  _exit(127);
}

int end_of(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

void expect_service(const Words& words, int exit_code) {
  Manager manager;
  setenv("WATCHDOG_USEC", "800000", 1);
  const pid_t child = start(words);
  unsetenv("WATCHDOG_USEC");
  EXPECT_EQ(manager.next("WATCHDOG=1"), "READY=1");
  for (int i = 0; i < 4; ++i) EXPECT_EQ(manager.next(), "WATCHDOG=1") << "beat " << i;
  kill(child, SIGTERM);
  EXPECT_EQ(manager.next("WATCHDOG=1"), "STOPPING=1");
  EXPECT_EQ(end_of(child), exit_code);
}

TEST(Service, ServerTellsItsManager) {
  TempDir dir;
  expect_service({kServer, "--config", "quick", "--run-dir", (dir.path() / "run").string(), "--listen",
                  "tcp://127.0.0.1:*", "--http", ""},
                 130);
}

TEST(Service, WorkerTellsItsManagerAlsoWithoutAMaster) {
  TempDir dir;
  expect_service({kWorker, "--slots", "1", "--rendezvous", (dir.path() / "none").string()}, 0);
}

// A run that has ended: a worker that came for it alone goes home, another waits for the next.
TEST(Service, AWorkerThatComesWhenTheRunIsOverEnds) {
  TempDir dir;
  const std::string where = (dir.path() / "rendezvous").string();
  std::ofstream(where) << "over = the run is finished\n";
  const Words worker{kWorker, "--slots", "1", "--rendezvous", where, "--wait-seconds", "1"};
  EXPECT_EQ(end_of(start(worker)), 6) << "a worker for any run did not wait for another";
  Words once = worker;
  once.emplace_back("--once");
  EXPECT_EQ(end_of(start(once)), 0);
}

// A copy of the variable that was meant for another process must not be answered.
TEST(Service, BeatsOnlyWhenMeant) {
  TempDir dir;
  Manager manager;
  setenv("WATCHDOG_USEC", "80000", 1);
  setenv("WATCHDOG_PID", "1", 1);
  const pid_t child =
      start({kWorker, "--slots", "1", "--rendezvous", (dir.path() / "none").string(), "--wait-seconds", "1"});
  unsetenv("WATCHDOG_USEC");
  unsetenv("WATCHDOG_PID");
  EXPECT_EQ(manager.next(), "READY=1");
  EXPECT_EQ(end_of(child), 6) << "a worker without a master did not give up";
  EXPECT_EQ(manager.waiting(), "") << "beats that nobody asked for";
}

}  // namespace
}  // namespace evograsp::testing

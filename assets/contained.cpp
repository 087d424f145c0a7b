#include "assets/contained.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>

#include "common/sanitized.h"

namespace evograsp::assets {
namespace {

enum class Verdict : char { kAnswer = 'A', kError = 'E' };

std::size_t address_space_in_use() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

void limit(int resource, rlim_t value) {
  const rlimit r{value, value};
  setrlimit(static_cast<__rlimit_resource>(resource), &r);
}

void enter_limits(const Containment& limits, std::size_t in_use) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // whoever wants the answer is gone
  limit(RLIMIT_CPU, static_cast<rlim_t>(std::ceil(limits.seconds)));
  limit(RLIMIT_FSIZE, 0);
  limit(RLIMIT_CORE, 0);
#ifndef EVOGRASP_SANITIZED  // sanitizers reserve terabytes of address space
  limit(RLIMIT_AS, in_use + limits.memory);
#else
  (void)in_use;
#endif
  const int null = open("/dev/null", O_RDWR);
  if (null >= 0) {
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(null, fd);
  }
  // Whatever the program does on these signals is not for the child.
  for (const int s : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGTERM, SIGINT, SIGHUP, SIGXCPU, SIGPIPE})
    std::signal(s, SIG_DFL);
}

void write_all(int fd, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = write(fd, data, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    data += n;
    size -= static_cast<std::size_t>(n);
  }
}

[[noreturn]] void child(const std::function<Result<std::string>()>& work, int out) {
  Verdict verdict = Verdict::kError;
  std::string text;
  try {
    Result<std::string> result = work();
    verdict = result ? Verdict::kAnswer : Verdict::kError;
    text = result ? std::move(*result) : std::move(result.error().message);
  } catch (const std::bad_alloc&) {
    text = "needs more memory than allowed";
  } catch (const std::exception& e) {
    text = e.what();
  } catch (...) {
    text = "failed for an unknown reason";
  }
  const char first = static_cast<char>(verdict);
  write_all(out, &first, 1);
  write_all(out, text.data(), text.size());
  _exit(0);
}

// Reads until the child closes its end; false when the deadline or the bound is passed.
bool read_answer(int fd, const Containment& limits, std::string& answer) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(10 * limits.seconds + 10);
  std::string block(1 << 16, '\0');
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd p{fd, POLLIN, 0};
    const int ready = poll(&p, 1, static_cast<int>(left));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t n = read(fd, block.data(), block.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return true;
    answer.append(block.data(), static_cast<std::size_t>(n));
    if (answer.size() > limits.answer) return false;
  }
}

}  // namespace

Result<std::string> run_contained(const std::function<Result<std::string>()>& work,
                                  const Containment& limits) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    return fail(ErrorCode::kIo, std::string("no pipe: ") + std::strerror(errno));
  const std::size_t in_use = address_space_in_use();
  const pid_t pid = fork();
  if (pid < 0) {
    close(ends[0]);
    close(ends[1]);
    return fail(ErrorCode::kIo, std::string("no process: ") + std::strerror(errno));
  }
  if (pid == 0) {
    close(ends[0]);
    enter_limits(limits, in_use);
    child(work, ends[1]);
  }
  close(ends[1]);
  std::string answer;
  const bool finished = read_answer(ends[0], limits, answer);
  close(ends[0]);
  if (!finished) kill(pid, SIGKILL);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  const std::string too_long = "took longer than " + std::to_string(static_cast<int>(limits.seconds)) + " s";
  if (!finished) {
    return fail(ErrorCode::kInvalid,
                answer.size() > limits.answer ? "gives more data than allowed" : too_long);
  }
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU || signal == SIGKILL) return fail(ErrorCode::kInvalid, too_long);
    return fail(ErrorCode::kInvalid, "crashed the reader (signal " + std::to_string(signal) + ")");
  }
  if (answer.empty()) return fail(ErrorCode::kInvalid, "gave no answer");
  const bool good = answer[0] == static_cast<char>(Verdict::kAnswer);
  answer.erase(0, 1);
  if (!good) return fail(ErrorCode::kInvalid, answer);
  return answer;
}

}  // namespace evograsp::assets

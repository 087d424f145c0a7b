#include "server/store_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "server/store_reader.h"

namespace evograsp::server {
namespace {

constexpr char kLockFile[] = "run.lock";

std::string holder(int descriptor) {
  char text[256];
  const ssize_t size = ::pread(descriptor, text, sizeof text, 0);
  return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : "another process";
}

std::string own_name() {
  char host[128] = "";
  ::gethostname(host, sizeof host - 1);
  return "process " + std::to_string(::getpid()) + " on " + host;
}

}  // namespace

Result<RunLock> RunLock::take(const std::filesystem::path& run_dir) {
  const std::filesystem::path file = run_dir / kLockFile;
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0)
    return fail(ErrorCode::kIo, file.string() + ": " + std::generic_category().message(errno) +
                                    "; the run folder must be writable");
  RunLock lock(descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
    return fail(ErrorCode::kUnavailable, run_dir.string() + ": the run is open in another server (" +
                                             holder(descriptor) +
                                             "); stop that one first, or ask it instead");
  const std::string name = own_name();
  // Only for the message above: what stands in the file decides nothing.
  if (::ftruncate(descriptor, 0) != 0 || ::pwrite(descriptor, name.data(), name.size(), 0) < 0) return lock;
  return lock;
}

RunLock::~RunLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool is_live(const std::filesystem::path& run_dir) {
  const int descriptor = ::open((run_dir / kLockFile).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool held = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return held;
}

}  // namespace evograsp::server

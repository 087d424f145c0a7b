#include "server/champion_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "common/digest.h"

namespace evograsp::server {

namespace {

Status io_error(const std::filesystem::path& file) {
  return fail(ErrorCode::kIo, file.string() + ": cannot be written: " + std::strerror(errno));
}

bool write_all(int fd, const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = write(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return fsync(fd) == 0;
}

}  // namespace

Status write_champion(const std::filesystem::path& run_dir, const proto::Champion& champion) {
  const std::filesystem::path file = run_dir / kChampionFile;
  const std::filesystem::path beside = run_dir / (std::string(kChampionFile) + ".part");
  const int fd = open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return io_error(beside);
  const bool written = write_all(fd, deterministic_bytes(champion));
  const int problem = errno;
  close(fd);
  errno = problem;
  if (written && rename(beside.c_str(), file.c_str()) == 0) return {};
  const Status status = io_error(written ? file : beside);
  unlink(beside.c_str());
  return status;
}

}  // namespace evograsp::server

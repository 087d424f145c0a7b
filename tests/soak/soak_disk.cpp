// Faults of the disk: full, read-only, and a byte that flips. Documented answers: one clear error, after
// which the run goes on when the cause is gone (or from a copy); or, for a flipped byte, going on from an
// earlier state.
#include <fstream>

#include "tests/soak/soak_run.h"

namespace evograsp::soak {

namespace fs = std::filesystem;

namespace {

constexpr int kIo = static_cast<int>(ErrorCode::kIo);
constexpr const char* kFiles[] = {"run.db", "run.db-wal"};

void flip(const fs::path& file, std::uint64_t bit) {
  std::fstream f(file, std::ios::in | std::ios::out | std::ios::binary);
  f.seekg(static_cast<std::streamoff>(bit / 8));
  const char byte = static_cast<char>(f.get() ^ (1 << (bit % 8)));
  f.seekp(static_cast<std::streamoff>(bit / 8));
  f.put(byte);
}

void copy_run(const fs::path& from, const fs::path& to) {
  fs::create_directories(to);
  for (const char* file : kFiles) {
    fs::remove(to / file);
    if (fs::exists(from / file)) fs::copy_file(from / file, to / file);
  }
  fs::remove(to / "run.db-shm");
}

}  // namespace

// The server has ended with this code and one line about run.db.
bool SoakRun::refused_in_one_line(int code) {
  const int ended = server_->finish();
  const std::string text = server_->log(), sign = "evograsp-server: ";
  std::size_t lines = 0, at = 0;
  for (; (at = text.find(sign, at)) != std::string::npos; at += sign.size())
    if (at == 0 || text[at - 1] == '\n') ++lines;
  if (ended == code && lines == 1 && text.find(run_dir().string()) != std::string::npos) return true;
  return complain("no clear error about the disk: ended with " + std::to_string(ended) + ", " +
                  std::to_string(lines) + " lines");
}

bool SoakRun::full_disk() {
  if (!disk_ || server_->ended()) return false;
  if (!disk_->fill()) return complain("the disk cannot be made full");
  wait_for([&] { return server_->ended(); }, 20);
  const bool hit = server_->ended() && server_->finish() != 0;
  const std::string text = server_->log();
  const bool named =
      text.find("disk is full") != std::string::npos || text.find("No space left") != std::string::npos;
  const bool right = !hit || (refused_in_one_line(kIo) && named);
  if (!disk_->restore()) return complain("the disk cannot be made large again");
  if (!right) return complain("a full disk was not called so");
  if (!hit || !check_kept()) return false;
  start_server();
  return true;
}

bool SoakRun::read_only_disk() {
  if (!disk_ || !take_down()) return false;
  if (!disk_->make_read_only()) return complain("the disk cannot be made read-only");
  launch_server(!seen_.empty());
  const bool right = refused_in_one_line(kIo);
  if (!disk_->restore()) return complain("the disk cannot be made writable again");
  if (right) start_server();
  return right;
}

bool SoakRun::flipped_byte() {
  if (!conditions_.flips || !take_down() || seen_.empty()) {
    if (good_ && conditions_.flips && server_->ended() && server_->finish() != 0) start_server();
    return false;
  }
  const fs::path copy = folder_ / "copy";
  copy_run(run_dir(), copy);
  const fs::path log = run_dir() / kFiles[1];
  std::error_code none;
  const bool in_log = fs::exists(log) && fs::file_size(log, none) > 0 && random_.chance(0.5);
  const fs::path file = in_log ? log : run_dir() / kFiles[0];
  flip(file, random_.next() % (8 * fs::file_size(file)));
  launch_server(true);
  if (!wait_for([&] { return server_->ended() || server_->log().find("workers: ") != std::string::npos; },
                30))
    return complain("a server neither takes up nor refuses a run with a flipped byte");
  if (server_->ended() && server_->finish() != 0) {
    const int code = server_->finish();
    if (code != static_cast<int>(ErrorCode::kInvalid) && code != static_cast<int>(ErrorCode::kUnsupported))
      return complain("a flipped byte ended the server with " + std::to_string(code));
    if (!refused_in_one_line(code)) return false;
    copy_run(copy, run_dir());
    start_server();
    return true;
  }
  // Taken up, perhaps from an earlier state: what that holds is what must be kept from now on.
  damaged_ = true;
  seen_.clear();
  if (!Tally::begin(run_dir()) || !remember()) return complain("run.db cannot be read after a flipped byte");
  return true;
}

}  // namespace evograsp::soak

// `evograsp keygen`: key pairs for connections beyond the own machine.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "cli/cli.h"
#include "cli/output.h"
#include "cli/report.h"
#include "cli/table.h"
#include "common/zap.h"

namespace evograsp::cli {
namespace {

struct KeygenOptions {
  std::string file, server, allow;
  bool force = false;
  bool json = false;
};

// An allow-list, opened before there is a key that would have to be taken back.
class AllowList {
 public:
  explicit AllowList(std::string file) : file_(std::move(file)) {
    if (!file_.empty()) fd_ = open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    struct stat info {};
    if (fd_ >= 0 && fstat(fd_, &info) == 0 && !S_ISREG(info.st_mode)) {
      close(fd_);
      fd_ = -1;
      errno = EINVAL;
    }
    problem_ = errno;
  }
  ~AllowList() {
    if (fd_ >= 0) close(fd_);
  }
  AllowList(const AllowList&) = delete;
  AllowList& operator=(const AllowList&) = delete;

  Status usable() const {
    if (file_.empty() || fd_ >= 0) return {};
    return fail(ErrorCode::kIo, file_ + ": cannot be written: " + std::strerror(problem_));
  }

  // One more line, which begins where a line begins. All of it or nothing.
  Status add(const CurveKeys& keys, const std::string& comment) const {
    if (file_.empty()) return {};
    const off_t end = lseek(fd_, 0, SEEK_END);
    char last = '\n';
    bool written = end == 0 || pread(fd_, &last, 1, end - 1) == 1;
    std::string line = last == '\n' ? "" : "\n";
    line += keys.public_key + " " + printable(comment) + "\n";
    written = written && write(fd_, line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
              fsync(fd_) == 0;
    if (written) return {};
    const int problem = errno;
    const bool back = end >= 0 && ftruncate(fd_, end) == 0;
    return fail(ErrorCode::kIo, file_ + ": cannot be written: " + std::strerror(problem) +
                                    (back ? "" : "; look at its last line"));
  }

 private:
  const std::string file_;
  int fd_ = -1;
  int problem_ = 0;
};

// With --force the old pair stays until the new one is on the disk.
// What stands in the list is what the file has: a pair that cannot be allowed is not kept.
Result<CurveKeys> make(const KeygenOptions& options, const std::string& server_key) {
  std::error_code error, ignored;
  const AllowList list(options.allow);
  if (Status ok = list.usable(); !ok) return tl::unexpected(ok.error());
  const bool there = std::filesystem::exists(std::filesystem::symlink_status(options.file, error));
  if (there && !options.force)
    return fail(ErrorCode::kInvalid, options.file +
                                         ": is there already; --force replaces it, and whoever knows "
                                         "the old public key has to be told the new one");
  if (there && std::filesystem::is_directory(options.file, error))
    return fail(ErrorCode::kInvalid, options.file + ": is a folder");
  const std::string fresh = there ? options.file + ".new" : options.file;
  if (there) std::filesystem::remove(fresh, error);
  auto keys = generate_keys(fresh, server_key);
  if (!keys) return keys;
  if (Status status = list.add(*keys, options.file); !status) {
    std::filesystem::remove(fresh, ignored);
    return tl::unexpected(status.error());
  }
  if (there) std::filesystem::rename(fresh, options.file, error);
  if (!there || !error) return keys;
  std::filesystem::remove(fresh, ignored);
  return fail(ErrorCode::kIo, options.file + ": cannot be replaced: " + error.message());
}

int keygen(const KeygenOptions& options) {
  std::string server_key;
  if (!options.server.empty()) {
    const auto server = load_keys(options.server);
    if (!server) return report(server.error());
    server_key = server->public_key;
  }
  const auto keys = make(options, server_key);
  if (!keys) return report(keys.error());
  if (options.json) {
    print_json(nlohmann::json{{"file", options.file}, {"public_key", keys->public_key}});
  } else {
    print(keys->public_key + "\n");
  }
  return kExitOk;
}

}  // namespace

void add_keygen(CLI::App& app, Outcome& outcome) {
  const auto options = std::make_shared<KeygenOptions>();
  CLI::App* sub = app.add_subcommand("keygen", "make a key pair for connections beyond this machine");
  sub->add_option("file", options->file, "where the pair goes (mode 0600)")->required()->type_name("FILE");
  sub->add_option("--server", options->server,
                  "for a worker: the server's key file, whose public key it expects");
  sub->add_option("--allow", options->allow,
                  "list of those who may connect, to which the new public key is added");
  sub->add_flag("--force", options->force, "replace a file that is there");
  sub->add_flag("--json", options->json, "answer as JSON");
  sub->footer(
      "Prints the public key. The secret never leaves the file.\n\n"
      "Examples:\n"
      "  evograsp keygen server.key\n"
      "  evograsp keygen worker.key --server server.key --allow workers.allow\n"
      "  evograsp-server --config cube --listen 'tcp://*:5555' --set net.curve_secret_key_file=server.key "
      "\\\n"
      "                  --set net.curve_allow_file=workers.allow\n"
      "  evograsp-worker --connect tcp://master:5555 --curve-key-file worker.key");
  sub->callback([options, &outcome] { outcome.exit_code = keygen(*options); });
}

}  // namespace evograsp::cli
